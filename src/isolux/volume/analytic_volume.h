#pragma once

#include <cmath>
#include <cstddef>
#include <type_traits>
#include <utility>
#include <vector>

#include "isolux/base/parallel.h"
#include "isolux/volume/volume.h"

namespace isolux {

/// `field(p_mm)` sampled at size^3 voxel centres on the cube from -half_mm to half_mm about the
/// world origin, with the identity direction. Whole-number types are rounded to nearest.
template <typename T, typename Field>
Volume sample_on_cube(int size, double half_mm, const Field& field) {
  const double spacing = 2 * half_mm / (size - 1);
  Volume volume;
  volume.dims = {size, size, size};
  volume.world_from_index = {diagonal({spacing, spacing, spacing}), {-half_mm, -half_mm, -half_mm}};
  const auto n = static_cast<std::size_t>(size);
  std::vector<T> voxels(n * n * n);
  parallel_for(n, 1, [&](std::size_t begin, std::size_t end) {
    for (std::size_t k = begin; k < end; ++k) {
      for (std::size_t j = 0; j < n; ++j) {
        for (std::size_t i = 0; i < n; ++i) {
          const Vec3 index{static_cast<double>(i), static_cast<double>(j), static_cast<double>(k)};
          const double value = field(volume.world_from_index.point(index));
          voxels[i + n * (j + n * k)] =
              static_cast<T>(std::is_integral_v<T> ? std::floor(value + 0.5) : value);
        }
      }
    }
  });
  volume.voxels = std::move(voxels);
  return volume;
}

}  // namespace isolux
