#include "isolux/volume/statistics.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <mutex>
#include <type_traits>

#include "isolux/base/parallel.h"

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

constexpr std::size_t kPiece = std::size_t{1} << 22;  // voxels

using Counts = std::vector<std::size_t>;

// How many times each value of a whole type occurs, from the lowest on.
template <typename T>
Counts counts_of(const T* voxels, std::size_t count) {
  constexpr int kLowest = std::numeric_limits<T>::lowest();
  Counts counts(std::size_t{1} << (8 * sizeof(T)));
  std::mutex adding;
  parallel_for(count, kPiece, [&](std::size_t begin, std::size_t end) {
    std::vector<std::uint32_t> here(counts.size());
    for (std::size_t n = begin; n < end; ++n) ++here[static_cast<std::size_t>(voxels[n] - kLowest)];
    const std::lock_guard lock(adding);
    for (std::size_t n = 0; n < counts.size(); ++n) counts[n] += here[n];
  });
  return counts;
}

struct Range {
  double low = std::numeric_limits<double>::infinity();
  double high = -low;
  std::size_t not_finite = 0;
};

Range range_of(const float* voxels, std::size_t count) {
  Range range;
  std::mutex adding;
  parallel_for(count, kPiece, [&](std::size_t begin, std::size_t end) {
    Range here;
    for (std::size_t n = begin; n < end; ++n) {
      const double value = voxels[n];
      if (!std::isfinite(value)) {
        ++here.not_finite;
        continue;
      }
      here.low = std::min(here.low, value);
      here.high = std::max(here.high, value);
    }
    const std::lock_guard lock(adding);
    range.low = std::min(range.low, here.low);
    range.high = std::max(range.high, here.high);
    range.not_finite += here.not_finite;
  });
  return range;
}

// Equal bins from `low` to `high`.
struct Bins {
  double low;
  std::size_t count;
  double per_value;

  Bins(double from, double to, int bins)
      : low(from),
        count(from == to ? 1 : static_cast<std::size_t>(bins)),
        per_value(static_cast<double>(count) / (from < to ? to - from : 1)) {}
  std::size_t at(double value) const {
    return std::min(count - 1, static_cast<std::size_t>((value - low) * per_value));
  }
};

// How many finite values lie in each bin.
Counts counts_in(const Bins& bins, const float* voxels, std::size_t count) {
  Counts counts(bins.count);
  std::mutex adding;
  parallel_for(count, kPiece, [&](std::size_t begin, std::size_t end) {
    Counts here(bins.count);
    for (std::size_t n = begin; n < end; ++n) {
      if (std::isfinite(voxels[n])) ++here[bins.at(voxels[n])];
    }
    const std::lock_guard lock(adding);
    for (std::size_t n = 0; n < counts.size(); ++n) counts[n] += here[n];
  });
  return counts;
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
  const std::size_t count = voxel_count(volume);
  visit_voxels(volume, [&]<typename T>(const VolumeView<T>& view) {
    if constexpr (std::is_integral_v<T>) {
      constexpr double kLowest = std::numeric_limits<T>::lowest();
      const Counts counts = counts_of(view.voxels, count);
      const auto first = std::ranges::find_if(counts, [](std::size_t c) { return c > 0; });
      const auto last = std::find_if(counts.rbegin(), counts.rend(), [](auto c) { return c > 0; });
      s.min = kLowest + static_cast<double>(first - counts.begin());
      s.max = kLowest + static_cast<double>(counts.rend() - last - 1);
      const Bins of(s.min, s.max, bins);
      s.histogram.assign(of.count, 0);
      for (auto at = first; at != last.base(); ++at) {
        s.histogram[of.at(kLowest + static_cast<double>(at - counts.begin()))] += *at;
      }
    } else {
      const Range range = range_of(view.voxels, count);
      s.not_finite = range.not_finite;
      if (range.low > range.high) return;
      s.min = range.low;
      s.max = range.high;
      s.histogram = counts_in(Bins(s.min, s.max, bins), view.voxels, count);
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
