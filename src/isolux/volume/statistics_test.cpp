#include "isolux/volume/statistics.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <numeric>

namespace isolux {
namespace {

Volume line_of(std::vector<float> voxels) {
  Volume volume;
  volume.dims = {static_cast<int>(voxels.size()), 1, 1};
  volume.voxels = std::move(voxels);
  return volume;
}

TEST(Statistics, values_that_are_no_number_are_counted_apart) {
  const ValueStatistics s = value_statistics(line_of({NAN, -2, 6, INFINITY, 1}));
  EXPECT_EQ(s.min, -2);
  EXPECT_EQ(s.max, 6);
  EXPECT_EQ(s.not_finite, 2u);
  EXPECT_EQ(std::accumulate(s.histogram.begin(), s.histogram.end(), std::size_t{0}), 3u);
  EXPECT_EQ(value_statistics(line_of({NAN})).not_finite, 1u);
}

// The definition, voxel by voxel, for more voxels than one thread is given at a stroke.
TEST(Statistics, every_type_is_counted_as_one_voxel_after_the_other_is) {
  const auto check = []<typename T>(T, int low, int high) {
    Volume volume;
    volume.dims = {211, 199, 113};
    std::vector<T> voxels(std::size_t{211} * 199 * 113);
    for (std::size_t n = 0; n < voxels.size(); ++n) {
      const auto at = static_cast<int>(n * 2654435761u % static_cast<unsigned>(high - low + 1));
      voxels[n] = static_cast<T>(low + at);
    }
    voxels.front() = static_cast<T>(low);
    voxels.back() = static_cast<T>(high);
    std::vector<std::size_t> expected(50);
    for (const T voxel : voxels) {
      const double at = (static_cast<double>(voxel) - low) * (50.0 / (high - low));
      ++expected[std::min<std::size_t>(49, static_cast<std::size_t>(at))];
    }
    volume.voxels = voxels;
    const ValueStatistics s = value_statistics(volume, 50);
    EXPECT_EQ(s.min, low);
    EXPECT_EQ(s.max, high);
    EXPECT_EQ(s.histogram, expected);
  };
  check(std::uint8_t{}, 3, 255);
  check(std::int16_t{}, -32768, 32767);
  check(std::int16_t{}, -1024, 3071);
  check(std::uint16_t{}, 0, 65535);
  check(float{}, -700, 900);
}

TEST(Statistics, otsu_parts_two_clusters_in_the_middle) {
  const Volume volume = line_of({0, 0.1F, 0.2F, 0, 9.8F, 10, 9.9F});
  const auto suggested = suggest_iso(volume, value_statistics(volume));
  ASSERT_EQ(suggested.size(), 1u);
  EXPECT_NEAR(suggested[0].value, 5, 0.1);  // the middle of the empty bins
  EXPECT_EQ(suggested[0].name, "threshold");
}

TEST(Statistics, hounsfield_units_suggest_bone_and_skin_where_they_occur) {
  Volume volume = line_of({-1000, 40, 1200});
  volume.units = "HU";
  const auto both = suggest_iso(volume, value_statistics(volume));
  ASSERT_EQ(both.size(), 2u);
  EXPECT_EQ(both[0].value, 300);
  EXPECT_EQ(both[1].value, -300);
  Volume soft = line_of({-1000, 40, 60});
  soft.units = "HU";
  EXPECT_EQ(suggest_iso(soft, value_statistics(soft)).front().value, -300);
}

TEST(Statistics, a_constant_volume_suggests_nothing) {
  const Volume volume = line_of({7, 7, 7});
  EXPECT_TRUE(suggest_iso(volume, value_statistics(volume)).empty());
}

}  // namespace
}  // namespace isolux
