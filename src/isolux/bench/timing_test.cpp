#include "isolux/bench/timing.h"

#include <gtest/gtest.h>

#include <numeric>

namespace isolux {
namespace {

TEST(Timing, TheMedianIsTheMiddleValueOrTheMeanOfTheMiddleTwo) {
  EXPECT_EQ(median({9, 1, 4}), 4);
  EXPECT_EQ(median({9, 1, 4, 2}), 3);
  EXPECT_EQ(median({7}), 7);
}

TEST(Timing, OneOfAHundredMayExceedThe99thPercentile) {
  std::vector<double> values(200);
  std::iota(values.rbegin(), values.rend(), 1.0);  // 200 down to 1: two may exceed it
  EXPECT_EQ(percentile_99(values), 198);
  EXPECT_EQ(percentile_99({3, 8, 5}), 8);
}

}  // namespace
}  // namespace isolux
