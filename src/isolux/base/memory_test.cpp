#include "isolux/base/memory.h"

#include <gtest/gtest.h>

#include "isolux/base/error.h"

namespace isolux {
namespace {

TEST(Memory, sizes_are_read_with_their_units) {
  EXPECT_EQ(parse_memory("500"), 500);
  EXPECT_EQ(parse_memory("8G"), 8e9);
  EXPECT_EQ(parse_memory("1.5M"), 1.5e6);
  EXPECT_NEAR(*parse_memory("100%") / *parse_memory("50%"), 2, 1e-12);
  for (const char* text : {"", "G", "-1", "8GB", "0", "%", "8 G"}) {
    EXPECT_EQ(parse_memory(text), std::nullopt) << text;
  }
}

TEST(Memory, more_than_the_limit_is_refused) {
  EXPECT_THROW(check_memory(1e18, "a volume"), WorkError);
  EXPECT_NO_THROW(check_memory(1e6, "a volume"));
}

TEST(Memory, bytes_are_told_in_readable_units) {
  EXPECT_EQ(bytes_text(999), "999 bytes");
  EXPECT_EQ(bytes_text(14811136), "14.8 MB");
}

}  // namespace
}  // namespace isolux
