#include "isolux/volume/volume.h"

namespace isolux {

std::size_t voxel_count(const Volume& volume) {
  return std::visit([](const auto& voxels) { return voxels.size(); }, volume.voxels);
}

std::size_t voxel_bytes(const Volume& volume) {
  return std::visit([](const auto& voxels) { return voxels.size() * sizeof(voxels[0]); },
                    volume.voxels);
}

std::size_t held_bytes(const Volume& volume) {
  const bool is_mapped =
      std::visit([](const auto& voxels) { return voxels.is_mapped(); }, volume.voxels);
  return is_mapped ? 0 : voxel_bytes(volume);
}

std::string voxel_type_name(const Volume& volume) {
  constexpr const char* kNames[] = {"u8", "i16", "u16", "f32"};
  return kNames[volume.voxels.index()];
}

Vec3 spacing_mm(const Volume& volume) {
  const Mat3& m = volume.world_from_index.linear;
  return {length(m.column[0]), length(m.column[1]), length(m.column[2])};
}

Mat3 direction(const Volume& volume) {
  const Mat3& m = volume.world_from_index.linear;
  return {{normalize(m.column[0]), normalize(m.column[1]), normalize(m.column[2])}};
}

std::array<Vec3, 8> box_corners(const Volume& volume) {
  std::array<Vec3, 8> corners;
  for (int c = 0; c < 8; ++c) {
    Vec3 index;
    for (int axis = 0; axis < 3; ++axis) {
      index[axis] = (c >> axis & 1) ? volume.dims[static_cast<std::size_t>(axis)] - 1 : 0;
    }
    corners[static_cast<std::size_t>(c)] = volume.world_from_index.point(index);
  }
  return corners;
}

}  // namespace isolux
