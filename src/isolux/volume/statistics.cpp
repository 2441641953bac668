#include "isolux/volume/statistics.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <type_traits>

namespace isolux {
namespace {

double bin_width(const ValueStatistics& s) {
  return (s.max - s.min) / static_cast<double>(s.histogram.size());
}

// The border between two bins that makes the variance between the two classes greatest. Where
// empty bins make several borders equally good, their middle.
double otsu_threshold(const ValueStatistics& s) {
  double total = 0, total_moment = 0;
  for (std::size_t b = 0; b < s.histogram.size(); ++b) {
    total += static_cast<double>(s.histogram[b]);
    total_moment += static_cast<double>(b) * static_cast<double>(s.histogram[b]);
  }
  double below = 0, below_moment = 0, best = -1;
  std::size_t first = 0, last = 0;
  for (std::size_t b = 0; b + 1 < s.histogram.size(); ++b) {
    below += static_cast<double>(s.histogram[b]);
    below_moment += static_cast<double>(b) * static_cast<double>(s.histogram[b]);
    const double above = total - below;
    if (below == 0 || above == 0) continue;
    const double gap = below_moment / below - (total_moment - below_moment) / above;
    const double between = below * above * gap * gap;
    if (between > best) {
      best = between;
      first = b;
    }
    if (between >= best) last = b;
  }
  return s.min + bin_width(s) * (static_cast<double>(first + last) / 2 + 1);
}

template <typename T>
bool look_like_labels(const VolumeView<T>& view) {
  constexpr std::size_t kMostLabels = 256, kFewestLabels = 2;  // beside 0
  constexpr double kShareAlike = 0.9;
  std::array<bool, std::numeric_limits<std::uint16_t>::max() + 1> seen{};
  std::size_t labels = 0, pairs = 0, alike = 0;
  const std::size_t rows =
      static_cast<std::size_t>(view.dims[1]) * static_cast<std::size_t>(view.dims[2]);
  const auto width = static_cast<std::size_t>(view.dims[0]);
  for (std::size_t row = 0; row < rows; ++row) {
    const T* const values = view.voxels + row * width;
    T last = 0;
    for (std::size_t i = 0; i < width; ++i) {
      const T value = values[i];
      if (value < 0) return false;
      if (value != 0 && last != 0) {
        ++pairs;
        alike += value == last;
      }
      last = value;
      if (seen[static_cast<std::size_t>(value)]) continue;
      seen[static_cast<std::size_t>(value)] = true;
      labels += value != 0;
      if (labels > kMostLabels) return false;
    }
  }
  return seen[0] && labels >= kFewestLabels && pairs > 0 &&
         static_cast<double>(alike) >= kShareAlike * static_cast<double>(pairs);
}

}  // namespace

bool holds_labels(const Volume& volume) {
  if (!volume.modality.empty()) return volume.modality == kSegmentation;
  return visit_voxels(volume, []<typename T>(const VolumeView<T>& view) {
    if constexpr (std::is_integral_v<T>) return look_like_labels(view);
    return false;
  });
}

ValueStatistics value_statistics(const Volume& volume, int bins) {
  ValueStatistics s;
  visit_voxels(volume, [&](const auto& view) {
    const std::size_t count = voxel_count(volume);
    double low = std::numeric_limits<double>::infinity();
    double high = -low;
    for (std::size_t n = 0; n < count; ++n) {
      const double value = static_cast<double>(view.voxels[n]);
      if (!std::isfinite(value)) {
        ++s.not_finite;
        continue;
      }
      low = std::min(low, value);
      high = std::max(high, value);
    }
    if (low > high) return;
    s.min = low;
    s.max = high;
    s.histogram.assign(low == high ? 1 : static_cast<std::size_t>(bins), 0);
    const double per_value =
        static_cast<double>(s.histogram.size()) / (high > low ? high - low : 1);
    const std::size_t last = s.histogram.size() - 1;
    for (std::size_t n = 0; n < count; ++n) {
      const double value = static_cast<double>(view.voxels[n]);
      if (!std::isfinite(value)) continue;
      ++s.histogram[std::min(last, static_cast<std::size_t>((value - low) * per_value))];
    }
  });
  return s;
}

std::vector<SuggestedIso> suggest_iso(const Volume& volume, const ValueStatistics& s) {
  std::vector<SuggestedIso> suggested;
  if (volume.units == "HU") {
    for (const SuggestedIso& one : {SuggestedIso{300, "bone"}, SuggestedIso{-300, "skin"}}) {
      if (s.min < one.value && one.value < s.max) suggested.push_back(one);
    }
  }
  if (suggested.empty() && s.min < 0.5 && 0.5 < s.max && holds_labels(volume)) {
    suggested.push_back({0.5, "labels"});
  }
  if (suggested.empty() && s.min < s.max) suggested.push_back({otsu_threshold(s), "threshold"});
  return suggested;
}

}  // namespace isolux
