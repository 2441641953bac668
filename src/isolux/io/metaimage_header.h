#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "isolux/io/stored_voxels.h"

namespace isolux {

/// What a MetaImage header (.mhd, .mha) says, checked for sense but not yet against the sizes of
/// its data files (see itk.org/Wiki/ITK/MetaIO/Documentation).
struct MetaImageHeader {
  std::size_t axes = 0;       ///< NDims, 1 to 4
  std::array<int, 4> dims{};  ///< 1 beyond the file's own axes
  StoredType type = StoredType::kU8;
  int channels = 1;  ///< numbers a voxel, one behind the other
  bool big_endian = false;
  bool deflated = false;
  Rescale rescale;
  std::vector<double> spacing;          ///< along each axis, positive
  std::vector<double> origin;           ///< of the first voxel's centre
  std::vector<double> matrix;           ///< axes x axes; row i is the direction of axis i
  std::string modality;                 ///< "CT", "MR", "US", or empty
  std::vector<std::string> data_files;  ///< each holds an equal share, in order
  std::uint64_t data_offset = 0;        ///< where the data begin in each of them
  bool data_at_end = false;             ///< they end where the file ends instead
};

/// Whether the first bytes of a file are such a header.
bool looks_like_metaimage(std::string_view first_bytes);

/// Reads the header of `path`; decisions go to `notes`.
/// @throws WorkError  where it is damaged, or of a kind not read here.
MetaImageHeader read_metaimage_header(const std::string& path, std::vector<std::string>& notes);

}  // namespace isolux
