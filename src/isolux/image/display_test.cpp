#include "isolux/image/display.h"

#include <gtest/gtest.h>

#include <cmath>

namespace isolux {
namespace {

using Pixel = std::array<std::uint8_t, 3>;

TEST(Display, raw_is_255_times_the_value_rounded_to_nearest_and_clamped) {
  const Display raw{Display::Curve::kRaw, 1};
  EXPECT_EQ(displayed(raw, {0, 0.5, 1}), (Pixel{0, 128, 255}));  // 127.5 goes up
  EXPECT_EQ(displayed(raw, {-1, 2, 0.1}), (Pixel{0, 255, 26}));  // 25.5
  EXPECT_EQ(displayed({Display::Curve::kRaw, 2}, {0.1, 0.25, 0.5}), (Pixel{51, 128, 255}));
}

TEST(Display, srgb_is_the_curve_of_iec_61966_2_1) {
  for (double value = 0; value <= 1; value += 0.001) {
    const double curve =
        value <= 0.0031308 ? 12.92 * value : 1.055 * std::pow(value, 1 / 2.4) - 0.055;
    EXPECT_NEAR(transfer({}, value), curve, 1e-14);
  }
  EXPECT_EQ(displayed({}, {0.2158605, 0, 1}), (Pixel{128, 0, 255}));  // 128 / 255 decodes to it
}

TEST(Display, infinite_radiance_is_white) {
  EXPECT_EQ(displayed({}, {INFINITY, 1e30, 0}), (Pixel{255, 255, 0}));
}

TEST(Display, linear_from_srgb_takes_the_transfer_function_back) {
  for (const double value : {0.0, 0.002, 0.0031308, 0.2, 1.0}) {
    EXPECT_NEAR(linear_from_srgb(transfer({}, value)), value, 1e-6);
  }
}

}  // namespace
}  // namespace isolux
