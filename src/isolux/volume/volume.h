#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <variant>

#include "isolux/base/affine.h"
#include "isolux/volume/voxels.h"

namespace isolux {

/// The modality of a volume whose values are the numbers of regions: DICOM's word for it.
inline constexpr const char* kSegmentation = "SEG";

/// Voxel values in the type the file stores, i fastest, then j, then k.
using VoxelArray =
    std::variant<Voxels<std::uint8_t>, Voxels<std::int16_t>, Voxels<std::uint16_t>, Voxels<float>>;

/// A grid of voxel values placed in world space (millimetres, LPS where the file says so). Between
/// voxel centres it is the trilinear interpolant; outside the outermost centres there is nothing.
struct Volume {
  std::array<int, 3> dims{};  ///< voxels along i, j, k; each at least 1
  VoxelArray voxels;          ///< dims[0] * dims[1] * dims[2] of them
  Affine world_from_index;    ///< voxel (i, j, k) -> mm; not singular
  std::string modality;       ///< "CT", "MR", ... as the file says; empty: unknown
  std::string units;          ///< "HU" for Hounsfield units; empty: unknown
};

/// The voxels of a Volume in their own type T, for inner loops.
template <typename T>
struct VolumeView {
  const T* voxels;
  std::array<int, 3> dims;

  std::size_t offset(int i, int j, int k) const {
    return static_cast<std::size_t>(i) +
           static_cast<std::size_t>(dims[0]) *
               (static_cast<std::size_t>(j) +
                static_cast<std::size_t>(dims[1]) * static_cast<std::size_t>(k));
  }
  double value(int i, int j, int k) const { return static_cast<double>(voxels[offset(i, j, k)]); }
};

/// Calls `use` with the VolumeView of the volume's own voxel type.
template <typename Use>
decltype(auto) visit_voxels(const Volume& volume, Use&& use) {
  return std::visit(
      [&]<typename T>(const Voxels<T>& voxels) -> decltype(auto) {
        return use(VolumeView<T>{voxels.data(), volume.dims});
      },
      volume.voxels);
}

/// Whether there is at least one cell (2 voxels along each axis), so that a surface can exist.
inline bool has_cells(const Volume& v) { return v.dims[0] > 1 && v.dims[1] > 1 && v.dims[2] > 1; }

std::size_t voxel_count(const Volume& volume);
/// Size of the voxels, in bytes.
std::size_t voxel_bytes(const Volume& volume);
/// Memory that the voxels hold, in bytes: none where they are mapped from their file.
std::size_t held_bytes(const Volume& volume);
/// "u8", "i16", "u16" or "f32".
std::string voxel_type_name(const Volume& volume);
/// Distance between neighbouring voxel centres along i, j, k in mm.
Vec3 spacing_mm(const Volume& volume);
/// Unit vectors along i, j, k as columns (not orthogonal where the grid is sheared).
Mat3 direction(const Volume& volume);
/// The eight corners of the box of voxel centres, in world space.
std::array<Vec3, 8> box_corners(const Volume& volume);

}  // namespace isolux
