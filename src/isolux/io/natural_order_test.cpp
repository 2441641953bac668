#include "isolux/io/natural_order.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <vector>

namespace isolux {
namespace {

TEST(NaturalOrder, runs_of_digits_count_as_numbers) {
  std::vector<std::string> names = {"s10.tif", "s2.tif", "s1.tif", "s002b.tif", "a", "s2.tif.old"};
  std::ranges::sort(names, comes_before);
  EXPECT_EQ(names, (std::vector<std::string>{"a", "s1.tif", "s2.tif", "s2.tif.old", "s002b.tif",
                                             "s10.tif"}));
}

TEST(NaturalOrder, is_an_order) {
  for (const char* name : {"", "1", "01", "a1", "a01b"}) EXPECT_FALSE(comes_before(name, name));
  EXPECT_NE(comes_before("01", "1"), comes_before("1", "01"));
  EXPECT_TRUE(comes_before("99999999999999999999998", "99999999999999999999999"));
}

}  // namespace
}  // namespace isolux
