#include "isolux/image/display_table.h"

#include <gtest/gtest.h>

#include <bit>
#include <cmath>
#include <cstdint>
#include <limits>
#include <random>

namespace isolux {
namespace {

void expect_as_displayed(const Display& display) {
  const DisplayTable table(display);
  const auto check = [&](float value) {
    EXPECT_EQ(table.byte(value), displayed(display, {value, 0, 0})[0])
        << value << " at exposure " << display.exposure;
  };
  for (int byte = 1; byte < 256; ++byte) {  // on both sides of every change
    const float least = table.least()[byte];
    check(least);
    check(std::nextafter(least, 0.0f));
  }
  std::mt19937 random(1);
  for (int n = 0; n < 20000; ++n) {
    check(std::uniform_real_distribution<float>(0, 1.1f)(random));
    check(std::bit_cast<float>(
        static_cast<std::uint32_t>(random() & 0x7F7FFFFFu)));  // any finite float
  }
  for (const float value : {0.0f, -0.0f, -1.0f, std::numeric_limits<float>::infinity()}) {
    check(value);
  }
}

TEST(DisplayTable, shows_the_bytes_of_the_definition) {
  expect_as_displayed({Display::Curve::kSrgb, 1});
  expect_as_displayed({Display::Curve::kRaw, 1});
  expect_as_displayed({Display::Curve::kSrgb, 1e-3});
  expect_as_displayed({Display::Curve::kRaw, 7.5});
  expect_as_displayed({Display::Curve::kSrgb, 1e30});
}

TEST(DisplayTable, no_exposure_is_black) {
  const DisplayTable table({Display::Curve::kSrgb, 0});
  EXPECT_EQ(table.byte(1e30f), 0);
}

}  // namespace
}  // namespace isolux
