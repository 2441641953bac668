#include "isolux/io/dicom_pixels.h"

#include <gtest/gtest.h>

#include <cstdint>
#include <vector>

namespace isolux {
namespace {

TEST(DicomPixels, bits_outside_the_stored_ones_are_left_out_and_the_sign_is_kept) {
  const std::vector<std::uint16_t> packed{0xF001, 0x0FFF, 0x0800, 0x07FF};
  std::vector<std::int16_t> voxels(4);
  bool rounds = false;
  ASSERT_TRUE(unpack({16, 12, 11, true}, packed.data(), 0, 4, {}, voxels.data(), rounds));
  EXPECT_EQ(voxels, (std::vector<std::int16_t>{1, -1, -2048, 2047}));
  ASSERT_TRUE(unpack({16, 12, 15, false}, packed.data(), 0, 4, {}, voxels.data(), rounds));
  EXPECT_EQ(voxels, (std::vector<std::int16_t>{0xF00, 0x0FF, 0x080, 0x07F}));
}

TEST(DicomPixels, single_bits_lie_lowest_first) {
  const std::vector<std::uint8_t> packed{0b10000001, 0b00000010};
  std::vector<std::uint8_t> voxels(4);
  bool rounds = false;
  ASSERT_TRUE(unpack({1, 1, 0, false}, packed.data(), 6, 4, {}, voxels.data(), rounds));
  EXPECT_EQ(voxels, (std::vector<std::uint8_t>{0, 1, 0, 1}));
}

TEST(DicomPixels, a_type_that_cannot_hold_a_value_says_so_and_floats_tell_rounding) {
  const std::vector<std::uint16_t> packed{0, 40000};
  std::vector<std::int16_t> whole(2);
  std::vector<float> real(2);
  bool rounds = false;
  EXPECT_FALSE(unpack({16, 16, 15, false}, packed.data(), 0, 2, {}, whole.data(), rounds));
  EXPECT_TRUE(unpack({16, 16, 15, false}, packed.data(), 0, 2, {1, -10000}, whole.data(), rounds));
  EXPECT_EQ(whole[1], 30000);
  EXPECT_FALSE(unpack({16, 16, 15, false}, packed.data(), 1, 1, {0.3, 0.1}, whole.data(), rounds));
  EXPECT_TRUE(unpack({16, 16, 15, false}, packed.data(), 0, 2, {0.5, 0.25}, real.data(), rounds));
  EXPECT_EQ(real, (std::vector<float>{0.25F, 20000.25F}));
  EXPECT_FALSE(rounds);
  EXPECT_TRUE(unpack({16, 16, 15, false}, packed.data(), 1, 1, {0.1, 0}, real.data(), rounds));
  EXPECT_FALSE(rounds);  // 0.1 * 40000 is 4000 in doubles
  EXPECT_TRUE(unpack({16, 16, 15, false}, packed.data(), 1, 1, {0.1, 0.3}, real.data(), rounds));
  EXPECT_TRUE(rounds);
}

}  // namespace
}  // namespace isolux
