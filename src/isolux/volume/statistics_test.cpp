#include "isolux/volume/statistics.h"

#include <gtest/gtest.h>

#include <cmath>
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
