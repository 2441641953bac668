#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "isolux/image/display.h"

namespace isolux {

/// `displayed` for floats by two look-ups, exactly: the least float that shows each byte is found
/// once, by bisection.
class DisplayTable {
 public:
  explicit DisplayTable(const Display& display);

  const Display& display() const { return display_; }

  std::uint8_t byte(float radiance) const {
    const std::int32_t byte = bases_[static_cast<std::size_t>(bucket(radiance))];
    return static_cast<std::uint8_t>(byte +
                                     (radiance >= least_[static_cast<std::size_t>(byte) + 1]));
  }

  // For code that looks up many values at once. A bucket is what floats have in common in their
  // upper bits, counted from first_bucket(), cut off to [0, buckets); it holds one change of byte
  // at most.
  static constexpr int kBucketShift = 15;
  std::int32_t first_bucket() const { return first_bucket_; }
  std::int32_t buckets() const { return static_cast<std::int32_t>(bases_.size()); }
  /// The byte at the beginning of each bucket.
  const std::int32_t* bases() const { return bases_.data(); }
  /// [b]: the least float that shows byte b or more; [256]: NaN.
  const float* least() const { return least_.data(); }

 private:
  std::int32_t bucket(float radiance) const;

  Display display_;
  std::int32_t first_bucket_ = 0;
  std::array<float, 257> least_{};
  std::vector<std::int32_t> bases_;
};

}  // namespace isolux
