#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "isolux/io/reader.h"

namespace isolux {

/// One file format: how its files are known, and how they are opened. The list of them is in
/// reader.cpp; a new format is one more file and one more line there.
struct Format {
  /// Whether a file's first bytes (up to 512) are of this format. `request` holds the name.
  bool (*recognises)(const ReadRequest& request, std::string_view first_bytes);
  /// Reads the header; the voxels wait for OpenedInput::read_voxels.
  OpenedInput (*open)(const ReadRequest& request);
};

Format nrrd_format();
Format nifti_format();
Format metaimage_format();
Format inv3_format();
Format tiff_format();
Format dicom_format();
Format vti_format();

/// A stack of TIFF files, in natural order of their names.
OpenedInput open_tiff_folder(const ReadRequest& request, std::vector<std::string> files);

inline constexpr int kDicomFolderDepth = 3;

/// The DICOM files of a folder in natural order; of its sub-folders, to kDicomFolderDepth, where it
/// has none itself.
std::vector<std::string> find_dicom_files(const std::string& folder);
/// One of the series in these files.
OpenedInput open_dicom_folder(const ReadRequest& request, const std::vector<std::string>& files);

/// What a headerless file of that many bytes might hold, as a hint: "14811136 bytes could be
/// 256x256x113 i16"; empty where no usual size fits.
std::string raw_guess(std::uintmax_t bytes);

/// Headerless voxels, described by the request's grid.
OpenedInput open_raw(const ReadRequest& request);

/// "phantom:NAME" or "phantom:NAME,size=N".
OpenedInput open_phantom(const ReadRequest& request);

/// Where the example head lies, or an empty text: Debian's documentation folder, then the cache
/// folder of isolux.
std::string find_example_head();

}  // namespace isolux
