#pragma once

#include <cstddef>
#include <optional>
#include <string_view>

namespace isolux {

/// Where the DICOM content of a file begins that starts with these bytes (512 are enough): 0 with
/// the preamble and "DICM", or without them where a data set comes at once. Nothing where it is not
/// DICOM, or only an index of other files (DICOMDIR).
std::optional<std::size_t> dicom_start(std::string_view first_bytes);

/// Whether it is such an index.
bool is_dicom_directory(std::string_view first_bytes);

}  // namespace isolux
