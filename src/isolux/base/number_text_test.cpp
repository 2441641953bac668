#include "isolux/base/number_text.h"

#include <gtest/gtest.h>

namespace isolux {
namespace {

TEST(NumberText, the_shortest_text_reads_back_as_the_same_number) {
  for (const double value : {0.1, 1.0 / 3, 300.0, -1e-7, 6.02e23, 0.30000000000000004}) {
    EXPECT_EQ(parse_number(to_text(value)), value);
  }
  EXPECT_EQ(to_text(0.1), "0.1");
  EXPECT_EQ(to_text(-0.0), "0");
  EXPECT_EQ(to_text9(1.0 / 3), "0.333333333");
}

TEST(NumberText, only_whole_texts_that_are_finite_numbers_are_taken) {
  for (const char* text : {"", " 1", "1 ", "1,5", "0x10", "nan", "inf", "1e999", "one", "1.2.3"}) {
    EXPECT_EQ(parse_number(text), std::nullopt) << text;
  }
  EXPECT_EQ(parse_number("+2.5"), 2.5);
  EXPECT_EQ(parse_whole_number("3.0"), std::nullopt);
  EXPECT_EQ(parse_whole_number("-3"), -3);
}

}  // namespace
}  // namespace isolux
