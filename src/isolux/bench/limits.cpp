#include "isolux/bench/limits.h"

#include <algorithm>
#include <atomic>
#include <cstring>

#include "isolux/base/parallel.h"

namespace isolux {
namespace {

std::uint64_t sum_of_words(const std::byte* bytes, std::size_t words) {
  std::uint64_t sum = 0;
  for (std::size_t n = 0; n < words; ++n) {
    std::uint64_t word = 0;
    std::memcpy(&word, bytes + sizeof word * n, sizeof word);
    sum += word;
  }
  return sum;
}

std::size_t bytes_per_pixel(const SurfaceBuffer& buffer) {
  return sizeof buffer.depth_mm[0] + sizeof buffer.normal_x[0] + sizeof buffer.normal_y[0] +
         sizeof buffer.normal_z[0] + sizeof buffer.surface[0];
}

}  // namespace

std::uint64_t read_voxels_once(const Volume& volume) {
  std::atomic<std::uint64_t> sum{0};
  visit_voxels(volume, [&](const auto& view) {
    const auto* bytes = reinterpret_cast<const std::byte*>(view.voxels);
    constexpr std::size_t kWord = sizeof(std::uint64_t);
    parallel_for(voxel_bytes(volume) / kWord, 1 << 16, [&](std::size_t begin, std::size_t end) {
      sum += sum_of_words(bytes + kWord * begin, end - begin);
    });
  });
  return sum;
}

RelightingLimit::RelightingLimit(const SurfaceBuffer& buffer, std::size_t hit_pixels)
    : read_(hit_pixels * bytes_per_pixel(buffer) / sizeof(std::uint64_t) + buffer.hits.size(), 1),
      written_(3 * static_cast<std::size_t>(buffer.width()) *
               static_cast<std::size_t>(buffer.height())) {}

void RelightingLimit::run() {
  const std::size_t pixels = written_.size() / 3;
  parallel_for(pixels, 16384, [&](std::size_t begin, std::size_t end) {
    const std::size_t first = read_.size() * begin / pixels, last = read_.size() * end / pixels;
    const auto* bytes = reinterpret_cast<const std::byte*>(read_.data() + first);
    // What is written depends on what was read, so that neither can be left out.
    const auto value = static_cast<std::uint8_t>(sum_of_words(bytes, last - first));
    std::fill(written_.data() + 3 * begin, written_.data() + 3 * end, value);
  });
}

}  // namespace isolux
