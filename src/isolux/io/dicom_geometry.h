#pragma once

#include <array>
#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include "isolux/base/affine.h"

namespace isolux {

/// What a file says of where one slice lies; nothing where it does not say. World space is LPS in
/// millimetres, as in DICOM.
struct SlicePlace {
  int columns = 1;                                       ///< voxels along i
  int rows = 1;                                          ///< voxels along j
  std::optional<Vec3> position = {};                     ///< of the first voxel's centre
  std::optional<std::array<Vec3, 2>> axes = {};          ///< unit vectors along i and along j
  std::optional<std::array<double, 2>> spacing_mm = {};  ///< along i and along j
  std::optional<double> distance_mm = {};                ///< to the next slice
};

/// The grid's layer k is slices [lower] and [upper] of the stack, mixed.
struct Layer {
  std::size_t lower = 0;
  std::size_t upper = 0;
  double share_of_upper = 0;
  bool operator==(const Layer&) const = default;
};

/// Slices made into a grid.
struct SliceStack {
  /// For each place along the normal, ascending, the slices that lie there (numbers into what was
  /// given, in that order). Places that have more than one have all the same number of them, which
  /// are the stack's volumes: time points, echoes.
  std::vector<std::vector<std::size_t>> places;
  std::vector<Layer> layers;  ///< into places; one a place, unmixed, where the places are regular
  bool is_resampled = false;
  Affine world_from_index;
  std::vector<std::string> notes;

  int volume_count() const { return static_cast<int>(places.front().size()); }
};

/// Puts the slices in order along their normal, i x j, whatever order they come in, and makes a
/// regular grid of them. Keeps the largest group of one size, orientation and spacing. Slices that
/// step sideways, by a tilted gantry, become a sheared grid. Missing slices and unequal distances
/// are filled by linear mixing. Slices without a position keep their order. What was decided, the
/// notes tell.
/// @throws WorkError  about `name`, where the slices are too irregular to be one volume, or an
/// orientation or spacing makes no sense. `slices` must not be empty.
SliceStack stack_slices(const std::string& name, const std::vector<SlicePlace>& slices);

}  // namespace isolux
