#pragma once

#include <string>
#include <vector>

namespace isolux::fuzz {

/// Small valid files of a format, made here: what a fuzzer starts from.
/// @param format  "nrrd", "nifti", "metaimage", "tiff", "inv3", "dicom", "vti", "raw" or "scene".
std::vector<std::string> seeds_of(const std::string& format);

}  // namespace isolux::fuzz
