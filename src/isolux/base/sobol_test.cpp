#include "isolux/base/sobol.h"

#include <gtest/gtest.h>

#include <cmath>
#include <set>
#include <vector>

namespace isolux {
namespace {

TEST(Sobol, every_box_of_equal_area_holds_one_point_whatever_its_shape) {
  for (const std::uint32_t seed : {0u, 1u, 77u, 0xdeadbeefu}) {
    for (int power = 0; power <= 8; ++power) {
      const std::uint32_t count = 1u << power;
      for (int across = 0; across <= power; ++across) {
        const double columns = 1 << across, rows = 1 << (power - across);
        for (const std::uint32_t first : {0u, count, 5 * count}) {
          std::set<std::pair<int, int>> boxes;
          for (std::uint32_t n = 0; n < count; ++n) {
            const UnitPoint p = sobol_point(first + n, seed);
            ASSERT_TRUE(p.u >= 0 && p.u < 1 && p.v >= 0 && p.v < 1);
            boxes.insert({static_cast<int>(p.u * columns), static_cast<int>(p.v * rows)});
          }
          ASSERT_EQ(boxes.size(), count) << power << " " << across << " " << seed;
        }
      }
    }
  }
}

TEST(Sobol, the_points_of_many_seeds_are_even_by_chi_square) {
  // One point of each of 64,000 sets into 16 x 16 boxes: chi square has 255 degrees of freedom, so
  // mean 255 and deviation sqrt(510) = 22.6; five deviations on either side are allowed.
  for (const std::uint32_t index : {0u, 1u, 6u, 1000u}) {
    constexpr int kSets = 64000, kBoxes = 256;
    std::vector<int> counts(kBoxes);
    for (std::uint32_t seed = 0; seed < kSets; ++seed) {
      const UnitPoint p = sobol_point(index, mixed(seed, 12345));
      ++counts[static_cast<std::size_t>(16 * static_cast<int>(16 * p.u) +
                                        static_cast<int>(16 * p.v))];
    }
    double chi_square = 0;
    const double expected = static_cast<double>(kSets) / kBoxes;
    for (const int count : counts) chi_square += (count - expected) * (count - expected) / expected;
    EXPECT_NEAR(chi_square, 255, 5 * 22.6) << index;
  }
}

TEST(Sobol, sets_of_different_seeds_are_independent_of_each_other) {
  // The correlation of u of two sets over n points has a deviation of 1 / sqrt(n).
  constexpr int kPoints = 4096;
  for (std::uint32_t seed = 0; seed < 20; ++seed) {
    double sum = 0;
    for (std::uint32_t n = 0; n < kPoints; ++n) {
      sum += (sobol_point(n, mixed(seed, 1)).u - 0.5) * (sobol_point(n, mixed(seed, 2)).u - 0.5);
    }
    EXPECT_LT(std::fabs(12 * sum / kPoints), 5 / std::sqrt(kPoints)) << seed;
  }
}

}  // namespace
}  // namespace isolux
