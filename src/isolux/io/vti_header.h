#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "isolux/base/affine.h"
#include "isolux/io/stored_voxels.h"

namespace isolux {

/// How the values of a VTK XML array lie in the file.
enum class VtiEncoding { kText, kBase64, kRaw };

/// What a VTK XML image file (.vti) says of the one array that is read, checked for sense and
/// against the file's size (see VTK's "File Formats", XML formats).
struct VtiHeader {
  std::array<int, 3> dims{};
  Affine world_from_index;
  std::string array_name;
  StoredType type = StoredType::kU8;
  int channels = 1;  ///< numbers a voxel, one behind the other
  VtiEncoding encoding = VtiEncoding::kRaw;
  bool big_endian = false;
  bool deflated = false;          ///< in blocks, by zlib
  int header_bytes = 4;           ///< width of the numbers before the data: 4 or 8
  std::uint64_t data_offset = 0;  ///< where in the file the array begins
  std::uint64_t data_end = 0;     ///< where it must end at the latest
  std::vector<std::string> notes;

  double number_count() const {
    return static_cast<double>(dims[0]) * dims[1] * dims[2] * channels;
  }
};

/// @throws WorkError  where the header is damaged, or of a kind not read here.
VtiHeader read_vti_header(const std::string& path);

}  // namespace isolux
