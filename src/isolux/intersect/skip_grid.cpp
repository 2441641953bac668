#include "isolux/intersect/skip_grid.h"

#include <algorithm>
#include <new>

#include "isolux/base/parallel.h"
#include "isolux/intersect/surface_cells.h"

namespace isolux {
namespace {

static_assert(BrickGrid::kCells == 2 * SkipGrid::kBlockCells);

// A row of blocks with room for the greatest leap on either side, in which nothing is.
class LeapRow {
 public:
  explicit LeapRow(std::size_t count) : leaps_(count + 2 * kRoom, SkipGrid::kGreatestLeap) {}
  std::uint8_t* begin() { return leaps_.data() + kRoom; }

 private:
  static constexpr std::size_t kRoom = 16;
  std::vector<std::uint8_t> leaps_;
};

// Of `count` blocks side by side the leaps in an octant, once those of the neighbouring rows in it
// are known: a cube is as large as the least of the seven that begin one block further, and one
// more. `step`: 1 or -1, along the row. `leaps` comes as 0 where a block has surface cells.
void find_leaps(const std::array<const std::uint8_t*, 3>& rows, std::size_t count,
                std::ptrdiff_t step, std::uint8_t* leaps, std::uint8_t* spare) {
  for (std::size_t x = 0; x < count; ++x) {
    std::uint8_t least = SkipGrid::kGreatestLeap - 1;
    for (const std::uint8_t* row : rows) {
      least = std::min({least, row[x], (row + step)[x]});
    }
    leaps[x] = std::min(leaps[x], static_cast<std::uint8_t>(least + 1));
  }
  // And of the blocks further on in this row: one further, then two, four and eight.
  for (const int far : {1, 2, 4, 8}) {
    const std::uint8_t* const there = leaps + far * step;
    for (std::size_t x = 0; x < count; ++x) {
      spare[x] = std::min(leaps[x], static_cast<std::uint8_t>(there[x] + far));
    }
    std::swap(leaps, spare);
  }
}

}  // namespace

SkipGrid::SkipGrid(const Volume& volume, const BrickGrid& bricks, double iso) {
  for (std::size_t axis = 0; axis < 3; ++axis) {
    dims_[axis] = (volume.dims[axis] - 1 + kBlockCells - 1) / kBlockCells;
  }
  stride_y_ = static_cast<std::size_t>(dims_[0]) + 2;
  stride_z_ = stride_y_ * (static_cast<std::size_t>(dims_[1]) + 2);
  const std::size_t count = stride_z_ * (static_cast<std::size_t>(dims_[2]) + 2);
  leaps_.assign(count, ~0u);
  cells_.reset(static_cast<std::uint64_t*>(std::calloc(count, sizeof(std::uint64_t))));
  if (!cells_) throw std::bad_alloc();

  std::vector<std::vector<Block>> found(static_cast<std::size_t>(bricks.dims()[2]));
  visit_voxels(volume, [&]<typename T>(const VolumeView<T>& view) {
    parallel_for(found.size(), 1, [&](std::size_t begin, std::size_t end) {
      for (std::size_t slab = begin; slab < end; ++slab) {
        std::array<int, 3> brick{0, 0, static_cast<int>(slab)};
        for (brick[1] = 0; brick[1] < bricks.dims()[1]; ++brick[1]) {
          for (brick[0] = 0; brick[0] < bricks.dims()[0]; ++brick[0]) {
            const BrickRange& range = bricks.at(brick);
            if (!(range.low <= iso && range.high >= iso)) continue;
            const BrickCells words = surface_cells(view, brick, Threshold<T>(iso));
            for (int n = 0; n < 8; ++n) {
              if (words[static_cast<std::size_t>(n)] == 0) continue;
              const Block block{2 * brick[0] + (n & 1), 2 * brick[1] + (n >> 1 & 1),
                                2 * brick[2] + (n >> 2)};
              cells_[index(block)] = words[static_cast<std::size_t>(n)];
              leaps_[index(block)] = 0;
              found[slab].push_back(block);
            }
          }
        }
      }
    });
  });
  for (const auto& slab : found) cubes_[0].insert(cubes_[0].end(), slab.begin(), slab.end());
  gather_cubes();
  measure_leaps();
}

// Each level from the one before: a cube of it holds up to eight of those.
void SkipGrid::gather_cubes() {
  Block dims = dims_;
  for (std::size_t level = 1; level < kLevels; ++level) {
    for (std::int32_t& count : dims) count = (count + 1) / 2;
    std::vector<std::uint8_t> is_there(static_cast<std::size_t>(dims[0]) *
                                       static_cast<std::size_t>(dims[1]) *
                                       static_cast<std::size_t>(dims[2]));
    for (const Block& part : cubes_[level - 1]) {
      const Block cube{part[0] / 2, part[1] / 2, part[2] / 2};
      std::uint8_t& known = is_there[static_cast<std::size_t>(
          cube[0] + std::int64_t{dims[0]} * (cube[1] + std::int64_t{dims[1]} * cube[2]))];
      if (!known) cubes_[level].push_back(cube);
      known = 1;
    }
  }
}

void SkipGrid::measure_leaps() {
  parallel_for(4, 1, [&](std::size_t begin, std::size_t end) {
    for (std::size_t down = begin; down < end; ++down) measure_leaps(static_cast<unsigned>(down));
  });
}

// For the two octants that run down along j and k where `down` has bit 0 and bit 1: a byte of each
// block's leaps. Slab after slab against the octants' way, so that what lies further on is known.
void SkipGrid::measure_leaps(unsigned down) {
  const std::size_t count = stride_y_, rows = static_cast<std::size_t>(dims_[1]) + 2,
                    slabs = static_cast<std::size_t>(dims_[2]) + 2;
  const auto ordered = [](std::size_t n, std::size_t of, bool is_down) {
    return is_down ? n : of - 1 - n;
  };
  using Slab = std::vector<LeapRow>;
  // Of both octants; the last row of each lies beyond the grid.
  std::array<Slab, 2> last, now;
  last.fill(Slab(rows + 1, LeapRow(count)));
  now = last;
  LeapRow spare(count);
  for (std::size_t n = 0; n < slabs; ++n) {
    const std::size_t z = ordered(n, slabs, down & 2);
    for (std::size_t m = 0; m < rows; ++m) {
      const std::size_t y = ordered(m, rows, down & 1);
      auto* const bytes =
          reinterpret_cast<std::uint8_t*>(&leaps_[z * stride_z_ + y * stride_y_]) + down;
      const std::size_t before = m == 0 ? rows : ordered(m - 1, rows, down & 1);
      for (std::size_t way = 0; way < 2; ++way) {
        std::uint8_t* const leaps = now[way][y].begin();
        for (std::size_t x = 0; x < count; ++x) {
          leaps[x] = bytes[4 * x] == 0 ? 0 : kGreatestLeap;
        }
        find_leaps({now[way][before].begin(), last[way][y].begin(), last[way][before].begin()},
                   count, way == 0 ? 1 : -1, leaps, spare.begin());
      }
      const std::uint8_t* const up = now[0][y].begin();
      const std::uint8_t* const back = now[1][y].begin();
      for (std::size_t x = 0; x < count; ++x) {
        bytes[4 * x] = static_cast<std::uint8_t>(up[x] | back[x] << 4);
      }
    }
    std::swap(last, now);
  }
}

double SkipGrid::bytes() const {
  double bytes = (sizeof(std::uint32_t) + sizeof(std::uint64_t)) * static_cast<double>(size());
  for (const auto& cubes : cubes_) bytes += static_cast<double>(cubes.size() * sizeof(Block));
  return bytes;
}

}  // namespace isolux
