#include "isolux/base/exact_math.h"

#include <gtest/gtest.h>

#include <cmath>

namespace isolux {
namespace {

TEST(ExactMath, pow_agrees_with_the_c_library_for_every_shininess) {
  for (const double exponent : {1 / 2.4, 1.0, 10.0, 40.0, 100.0, 1000.0}) {
    for (double base = 0.001; base < 1.5; base += 0.00137) {
      const double expected = std::pow(base, exponent);
      if (expected < 1e-300 || std::isinf(expected)) continue;
      // The error of y log2 x, some 2^-53 relative, is multiplied by |y ln x| in the result.
      const double bound = 4e-16 * (4 + std::fabs(exponent * std::log(base)));
      EXPECT_NEAR(exact::pow(base, exponent) / expected, 1, bound) << base << "^" << exponent;
    }
  }
}

TEST(ExactMath, pow_has_its_limits) {
  EXPECT_EQ(exact::pow(0, 40), 0);
  EXPECT_EQ(exact::pow(0, 0), 1);
  EXPECT_EQ(exact::pow(0.5, 0), 1);
  EXPECT_EQ(exact::pow(1, 1e6), 1);
  EXPECT_EQ(exact::pow(0.9, 1e6), 0);  // 10^-45757 is below every double
  EXPECT_EQ(exact::pow(2, 10), 1024);
}

TEST(ExactMath, exp_sin_cos_and_tan_agree_with_the_c_library) {
  for (double x = -30; x < 30; x += 0.0137) {
    EXPECT_NEAR(exact::exp(x) / std::exp(x), 1, 1e-14) << x;
    EXPECT_NEAR(exact::sin(x), std::sin(x), 1e-15) << x;
    EXPECT_NEAR(exact::cos(x), std::cos(x), 1e-15) << x;
  }
  EXPECT_NEAR(exact::tan(exact::radians(15)), 2 - std::sqrt(3), 1e-15);
}

}  // namespace
}  // namespace isolux
