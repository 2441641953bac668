#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "isolux/volume/volume.h"

namespace isolux {

/// What the voxel values of a volume are like. NaN and infinite voxels are counted apart.
struct ValueStatistics {
  double min = 0;  ///< of the finite values; 0 where there are none
  double max = 0;
  std::size_t not_finite = 0;
  /// Finite values counted in equal bins from min to max; one bin where min == max.
  std::vector<std::size_t> histogram;
};

ValueStatistics value_statistics(const Volume& volume, int bins = 256);

/// Whether the values are the numbers of regions rather than measurements: the modality says so, or
/// there is none and they are whole, not negative, at most 256 different ones, and mostly alike in
/// neighbours that are not 0.
bool holds_labels(const Volume& volume);

/// An iso value worth showing first, and what it shows: "bone", "skin", "labels" or "threshold".
struct SuggestedIso {
  double value;
  std::string name;
};

/// Hounsfield units: bone at 300 and skin at -300, where the values reach them. Labels: 0.5, which
/// bounds them all, since between two labels their numbers mean nothing. Else the threshold
/// that parts the histogram best (Otsu 1979, "A threshold selection method from gray-level
/// histograms"). Empty for a constant volume.
std::vector<SuggestedIso> suggest_iso(const Volume& volume, const ValueStatistics& statistics);

}  // namespace isolux
