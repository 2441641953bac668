#include "isolux/mesh/inside_bits.h"

#include <atomic>
#include <cmath>
#include <cstring>
#include <limits>

#include "isolux/base/parallel.h"

namespace isolux {
namespace {

using Word = InsideBits::Word;

// The bits of up to 64 voxels. The flags are made first, by a loop that compilers turn into lanes;
// then eight at a time are gathered into a byte: the factor moves bit 8 n to bit 56 + n.
template <typename T, typename Test>
Word bits_of(const T* voxels, int count, const Test& test) {
  std::array<std::uint8_t, 64> flags{};
  for (int n = 0; n < count; ++n) flags[static_cast<std::size_t>(n)] = test(voxels[n]);
  Word bits = 0;
  for (std::size_t byte = 0; byte < 8; ++byte) {
    Word eight = 0;
    std::memcpy(&eight, flags.data() + 8 * byte, 8);
    bits |= (eight * 0x0102040810204080 >> 56) << (8 * byte);
  }
  return bits;
}

// Calls `test` with voxels of type T, where at_or_above(v) == (v >= iso) for every value of T.
template <typename T>
T least_at_or_above(double iso) {
  if constexpr (std::is_integral_v<T>) {
    return static_cast<T>(std::ceil(iso));
  } else {
    const T nearest = static_cast<T>(iso);
    return nearest < iso ? std::nextafter(nearest, std::numeric_limits<T>::infinity()) : nearest;
  }
}

template <typename T>
void fill(const VolumeView<T>& view, int words, std::vector<Word>& bits, const auto& test) {
  const auto rows = static_cast<std::size_t>(view.dims[1]) * static_cast<std::size_t>(view.dims[2]);
  const auto along = static_cast<std::size_t>(view.dims[0]);
  bits.resize(rows * static_cast<std::size_t>(words));
  parallel_for(rows, 64, [&](std::size_t begin, std::size_t end) {
    for (std::size_t row = begin; row < end; ++row) {
      for (int w = 0; w < words; ++w) {
        const T* voxels = view.voxels + row * along + 64 * static_cast<std::size_t>(w);
        const int count = std::min(64, view.dims[0] - 64 * w);
        bits[row * static_cast<std::size_t>(words) + static_cast<std::size_t>(w)] =
            count == 64 ? bits_of(voxels, 64, test) : bits_of(voxels, count, test);
      }
    }
  });
}

template <typename T>
bool all_finite(const VolumeView<T>& view, std::size_t count) {
  std::atomic<bool> all = true;
  parallel_for(count, 1 << 16, [&](std::size_t begin, std::size_t end) {
    T sum = 0;  // of zeros; not a number where one voxel is not
    for (std::size_t n = begin; n < end; ++n) sum += 0 * view.voxels[n];
    if (!std::isfinite(sum)) all = false;
  });
  return all;
}

}  // namespace

InsideBits::InsideBits(const Volume& volume, double iso)
    : dims_(volume.dims), words_((volume.dims[0] + 63) / 64) {
  visit_voxels(volume, [&]<typename T>(const VolumeView<T>& view) {
    if (std::is_integral_v<T> && iso > std::numeric_limits<T>::max()) {
      fill(view, words_, inside_, [](T) { return false; });
    } else if (std::is_integral_v<T> && iso <= std::numeric_limits<T>::lowest()) {
      fill(view, words_, inside_, [](T) { return true; });
    } else {
      const T least = least_at_or_above<T>(iso);
      fill(view, words_, inside_, [least](T value) { return value >= least; });
    }
    if constexpr (!std::is_integral_v<T>) {
      if (all_finite(view, voxel_count(volume))) return;
      fill(view, words_, finite_, [](T value) { return std::isfinite(value); });
    }
  });
}

Word InsideBits::row_of_cells(int w) const {
  const int cells = dims_[0] - 1 - 64 * w;
  return cells >= 64 ? ~Word{0} : cells <= 0 ? 0 : (Word{1} << cells) - 1;
}

Word InsideBits::sound_cells(int j, int k, int w) const {
  if (j < 0 || k < 0 || w < 0 || j + 1 >= dims_[1] || k + 1 >= dims_[2]) return 0;
  Word sound = row_of_cells(w);
  if (finite_.empty()) return sound;
  for (const auto& [b, c] : {std::array{j, k}, {j + 1, k}, {j, k + 1}, {j + 1, k + 1}}) {
    sound &= at(finite_, b, c, w) & next(finite_, b, c, w);
  }
  return sound;
}

Word InsideBits::crossed_cells(int j, int k, int w) const {
  const Word rows[4] = {inside(j, k, w), inside(j + 1, k, w), inside(j, k + 1, w),
                        inside(j + 1, k + 1, w)};
  const Word nexts[4] = {inside_next(j, k, w), inside_next(j + 1, k, w), inside_next(j, k + 1, w),
                         inside_next(j + 1, k + 1, w)};
  const Word any =
      rows[0] | rows[1] | rows[2] | rows[3] | nexts[0] | nexts[1] | nexts[2] | nexts[3];
  const Word all =
      rows[0] & rows[1] & rows[2] & rows[3] & nexts[0] & nexts[1] & nexts[2] & nexts[3];
  const Word mixed = any & ~all;
  return mixed == 0 ? 0 : mixed & sound_cells(j, k, w);
}

Word InsideBits::edges_of_sound_cells(int axis, int j, int k, int w) const {
  if (axis == 0) {
    return sound_cells(j, k, w) | sound_cells(j - 1, k, w) | sound_cells(j, k - 1, w) |
           sound_cells(j - 1, k - 1, w);
  }
  const int j1 = axis == 2 ? j - 1 : j, k1 = axis == 1 ? k - 1 : k;
  const Word here = sound_cells(j, k, w) | sound_cells(j1, k1, w);
  const Word before = sound_cells(j, k, w - 1) | sound_cells(j1, k1, w - 1);
  return here | here << 1 | before >> 63;
}

Word InsideBits::crossed_edges(int axis, int j, int k, int w) const {
  Word crossed = inside(j, k, w);
  if (axis == 0) {
    crossed = (crossed ^ inside_next(j, k, w)) & row_of_cells(w);
  } else if (axis == 1) {
    crossed = j + 1 < dims_[1] ? crossed ^ inside(j + 1, k, w) : 0;
  } else {
    crossed = k + 1 < dims_[2] ? crossed ^ inside(j, k + 1, w) : 0;
  }
  if (crossed == 0 || finite_.empty()) return crossed;
  return crossed & edges_of_sound_cells(axis, j, k, w);
}

}  // namespace isolux
