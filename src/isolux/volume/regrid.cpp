#include "isolux/volume/regrid.h"

#include <algorithm>
#include <cmath>
#include <type_traits>
#include <utility>

#include "isolux/base/parallel.h"

namespace isolux {
namespace {

// Voxels of type T on a new grid, from `value_at(i, j, k)`, slices in parallel.
template <typename T, typename ValueAt>
std::vector<T> filled(const std::array<int, 3>& dims, const ValueAt& value_at) {
  const auto nx = static_cast<std::size_t>(dims[0]), ny = static_cast<std::size_t>(dims[1]);
  std::vector<T> voxels(nx * ny * static_cast<std::size_t>(dims[2]));
  parallel_for(static_cast<std::size_t>(dims[2]), 1, [&](std::size_t begin, std::size_t end) {
    for (std::size_t k = begin; k < end; ++k) {
      for (std::size_t j = 0; j < ny; ++j) {
        for (std::size_t i = 0; i < nx; ++i) {
          voxels[i + nx * (j + ny * k)] =
              value_at(static_cast<int>(i), static_cast<int>(j), static_cast<int>(k));
        }
      }
    }
  });
  return voxels;
}

// Where a sample lies between two voxels along one axis.
struct Between {
  int low;
  int high;
  double part;
};

Between between(double index, int count) {
  const int low = std::clamp(static_cast<int>(std::floor(index)), 0, count - 1);
  const int high = std::min(low + 1, count - 1);
  return {low, high, std::clamp(index - low, 0.0, 1.0)};
}

double mixed(double a, double b, double part) {
  if (part == 0) return a;  // so that a NaN without weight does not count
  if (part == 1) return b;
  return a + part * (b - a);
}

template <typename T>
double interpolated(const VolumeView<T>& v, Vec3 index) {
  const Between x = between(index.x, v.dims[0]), y = between(index.y, v.dims[1]),
                z = between(index.z, v.dims[2]);
  const auto along_x = [&](int j, int k) {
    return mixed(v.value(x.low, j, k), v.value(x.high, j, k), x.part);
  };
  const auto along_y = [&](int k) { return mixed(along_x(y.low, k), along_x(y.high, k), y.part); };
  return mixed(along_y(z.low), along_y(z.high), z.part);
}

// An empty volume whose values mean the same.
Volume described_like(const Volume& volume) {
  Volume result;
  result.modality = volume.modality;
  result.units = volume.units;
  return result;
}

}  // namespace

Volume cropped(const Volume& volume, const VoxelBlock& block) {
  Volume result = described_like(volume);
  const int i0 = block.first[0], j0 = block.first[1], k0 = block.first[2];
  for (std::size_t axis = 0; axis < 3; ++axis) {
    result.dims[axis] = block.last[axis] - block.first[axis] + 1;
  }
  result.world_from_index = volume.world_from_index;
  result.world_from_index.offset = volume.world_from_index.point(
      {static_cast<double>(i0), static_cast<double>(j0), static_cast<double>(k0)});
  result.voxels = visit_voxels(volume, [&]<typename T>(const VolumeView<T>& view) -> VoxelArray {
    return filled<T>(result.dims, [&](int i, int j, int k) {
      return view.voxels[view.offset(i + i0, j + j0, k + k0)];
    });
  });
  return result;
}

std::array<double, 3> resampled_dims(const Volume& volume, Vec3 spacing_mm) {
  const Vec3 old_spacing = isolux::spacing_mm(volume);
  std::array<double, 3> dims{};
  for (int axis = 0; axis < 3; ++axis) {
    const auto a = static_cast<std::size_t>(axis);
    // A hair more, so that 10 mm at 0.1 mm are 101 voxels whatever 10 / 0.1 rounds to.
    dims[a] = std::floor((volume.dims[a] - 1) * old_spacing[axis] / spacing_mm[axis] + 1e-6) + 1;
  }
  return dims;
}

Volume resampled(const Volume& volume, Vec3 spacing_mm) {
  Volume result = described_like(volume);
  const Vec3 old_spacing = isolux::spacing_mm(volume);
  const auto dims = resampled_dims(volume, spacing_mm);
  Vec3 ratio;
  for (int axis = 0; axis < 3; ++axis) {
    result.dims[static_cast<std::size_t>(axis)] =
        static_cast<int>(dims[static_cast<std::size_t>(axis)]);
    ratio[axis] = spacing_mm[axis] / old_spacing[axis];
  }
  result.world_from_index = {direction(volume) * diagonal(spacing_mm),
                             volume.world_from_index.offset};
  result.voxels = visit_voxels(volume, [&]<typename T>(const VolumeView<T>& view) -> VoxelArray {
    return filled<T>(result.dims, [&](int i, int j, int k) {
      const double value = interpolated(view, {i * ratio.x, j * ratio.y, k * ratio.z});
      return static_cast<T>(std::is_integral_v<T> ? std::floor(value + 0.5) : value);
    });
  });
  return result;
}

}  // namespace isolux
