#include "isolux/image/display_table.h"

#include <algorithm>
#include <bit>
#include <limits>

namespace isolux {
namespace {

// Floats >= 0 are in the order of their bits.
std::int32_t bits_of(float value) { return std::bit_cast<std::int32_t>(value); }

}  // namespace

DisplayTable::DisplayTable(const Display& display) : display_(display) {
  constexpr float kInfinity = std::numeric_limits<float>::infinity();
  least_[0] = 0;
  for (int byte = 1; byte < 256; ++byte) {
    std::int32_t low = bits_of(least_[static_cast<std::size_t>(byte) - 1]);
    std::int32_t high = bits_of(kInfinity);
    while (low < high) {
      const std::int32_t middle = low + (high - low) / 2;
      const double radiance = std::bit_cast<float>(middle);
      const bool is_shown = displayed(display, {radiance, 0, 0})[0] >= byte;
      (is_shown ? high : low) = is_shown ? middle : middle + 1;
    }
    least_[static_cast<std::size_t>(byte)] = std::bit_cast<float>(low);
  }
  least_[256] = std::numeric_limits<float>::quiet_NaN();  // nothing is at or above it

  first_bucket_ = bits_of(least_[1]) >> kBucketShift;
  const std::int32_t last = bits_of(least_[255]) >> kBucketShift;
  int byte = 0;
  for (std::int32_t bucket = first_bucket_; bucket <= last + 1; ++bucket) {
    const float begin = bucket == first_bucket_ ? 0 : std::bit_cast<float>(bucket << kBucketShift);
    while (byte < 255 && least_[static_cast<std::size_t>(byte) + 1] <= begin) ++byte;
    bases_.push_back(byte);
  }
}

std::int32_t DisplayTable::bucket(float radiance) const {
  return std::clamp((bits_of(std::max(radiance, 0.0f)) >> kBucketShift) - first_bucket_, 0,
                    buckets() - 1);
}

}  // namespace isolux
