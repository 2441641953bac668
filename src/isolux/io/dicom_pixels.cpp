#include "isolux/io/dicom_pixels.h"

#include <cmath>
#include <cstdint>
#include <cstring>
#include <limits>
#include <type_traits>

namespace isolux {
namespace {

// The stored bits of a number in its unsigned type.
class StoredBits {
 public:
  explicit StoredBits(const PixelPacking& packing)
      : shift_(packing.high_bit + 1 - packing.bits_stored),
        mask_((std::uint64_t{1} << packing.bits_stored) - 1),
        sign_(packing.is_signed ? std::uint64_t{1} << (packing.bits_stored - 1) : 0) {}
  std::int64_t operator()(std::uint64_t raw) const {
    const std::uint64_t bits = (raw >> shift_) & mask_;
    return static_cast<std::int64_t>(bits ^ sign_) - static_cast<std::int64_t>(sign_);
  }

 private:
  int shift_;
  std::uint64_t mask_, sign_;
};

template <typename Raw>
Raw raw_at(const void* packed, std::size_t n) {
  Raw raw;
  std::memcpy(&raw, static_cast<const char*>(packed) + n * sizeof(Raw), sizeof(Raw));
  return raw;
}

std::uint64_t bit_at(const void* packed, std::size_t n) {
  return (raw_at<std::uint8_t>(packed, n / 8) >> (n % 8)) & 1;
}

template <typename Voxel, typename StoredAt>
bool unpack_each(const StoredAt& stored_at, std::size_t count, const Rescale& rescale,
                 Voxel* voxels, bool& rounds) {
  bool is_exact = true;
  for (std::size_t n = 0; n < count; ++n) {
    const double value = rescale.slope * static_cast<double>(stored_at(n)) + rescale.intercept;
    if constexpr (std::is_floating_point_v<Voxel>) {
      voxels[n] = static_cast<Voxel>(value);
      is_exact = is_exact && (static_cast<double>(voxels[n]) == value || std::isnan(value));
    } else {
      const bool fits = value >= std::numeric_limits<Voxel>::lowest() &&
                        value <= std::numeric_limits<Voxel>::max();
      voxels[n] = static_cast<Voxel>(fits ? value : 0);
      is_exact = is_exact && voxels[n] == value;
    }
  }
  if constexpr (!std::is_floating_point_v<Voxel>) return is_exact;
  rounds = rounds || !is_exact;
  return true;
}

}  // namespace

template <typename Voxel>
bool unpack(const PixelPacking& packing, const void* packed, std::size_t first, std::size_t count,
            const Rescale& rescale, Voxel* voxels, bool& rounds) {
  const StoredBits bits(packing);
  const auto each = [&](auto stored_at) {
    return unpack_each(stored_at, count, rescale, voxels, rounds);
  };
  if (packing.is_float && packing.bits_allocated == 64) {
    return each([&](std::size_t n) { return raw_at<double>(packed, first + n); });
  }
  if (packing.is_float) {
    return each([&](std::size_t n) { return raw_at<float>(packed, first + n); });
  }
  switch (packing.bits_allocated) {
    case 1:
      return each([&](std::size_t n) { return bit_at(packed, first + n); });
    case 8:
      return each([&](std::size_t n) { return bits(raw_at<std::uint8_t>(packed, first + n)); });
    case 16:
      return each([&](std::size_t n) { return bits(raw_at<std::uint16_t>(packed, first + n)); });
    default:
      return each([&](std::size_t n) { return bits(raw_at<std::uint32_t>(packed, first + n)); });
  }
}

template bool unpack(const PixelPacking&, const void*, std::size_t, std::size_t, const Rescale&,
                     std::uint8_t*, bool&);
template bool unpack(const PixelPacking&, const void*, std::size_t, std::size_t, const Rescale&,
                     std::int16_t*, bool&);
template bool unpack(const PixelPacking&, const void*, std::size_t, std::size_t, const Rescale&,
                     std::uint16_t*, bool&);
template bool unpack(const PixelPacking&, const void*, std::size_t, std::size_t, const Rescale&,
                     float*, bool&);

}  // namespace isolux
