#include "isolux/io/stored_voxels.h"

#include <gtest/gtest.h>

#include <cmath>

#include "isolux/base/error.h"

namespace isolux {
namespace {

struct Read {
  VoxelArray voxels;
  std::vector<std::string> notes;
  int passes = 0;
};

template <typename Stored>
Read read_telling(StoredType type, const std::vector<Stored>& stored, Rescale rescale = {}) {
  Read result;
  const auto from_the_first = [&]() -> ReadNext {
    ++result.passes;
    return
        [next = reinterpret_cast<const char*>(stored.data())](char* to, std::size_t bytes) mutable {
          std::copy_n(next, bytes, to);
          next += bytes;
        };
  };
  result.voxels =
      voxels_read("a", type, stored.size(), false, rescale, from_the_first, result.notes);
  return result;
}

template <typename Stored>
VoxelArray read(StoredType type, const std::vector<Stored>& stored, Rescale rescale = {}) {
  return read_telling(type, stored, rescale).voxels;
}

TEST(StoredVoxels, the_four_voxel_types_are_kept_as_they_are) {
  EXPECT_EQ(read<std::uint8_t>(StoredType::kU8, {0, 255}),
            VoxelArray(std::vector<std::uint8_t>{0, 255}));
  EXPECT_EQ(read<std::int16_t>(StoredType::kI16, {-32768, 5}),
            VoxelArray(std::vector<std::int16_t>{-32768, 5}));
  EXPECT_EQ(read<float>(StoredType::kF32, {1, 2}), VoxelArray(std::vector<float>{1, 2}));
}

TEST(StoredVoxels, whole_values_take_the_narrowest_type_that_holds_them) {
  EXPECT_EQ(read<std::int32_t>(StoredType::kI32, {-1024, 3071}),
            VoxelArray(std::vector<std::int16_t>{-1024, 3071}));
  EXPECT_EQ(read<std::uint32_t>(StoredType::kU32, {0, 65535}),
            VoxelArray(std::vector<std::uint16_t>{0, 65535}));
  EXPECT_EQ(read<std::uint16_t>(StoredType::kU16, {0, 4095}, {1, -1024}),
            VoxelArray(std::vector<std::int16_t>{-1024, 3071}));
  EXPECT_EQ(read<std::int8_t>(StoredType::kI8, {-3, 4}),
            VoxelArray(std::vector<std::int16_t>{-3, 4}));
}

TEST(StoredVoxels, everything_else_becomes_floats_and_rounding_is_told) {
  EXPECT_EQ(read<std::uint8_t>(StoredType::kU8, {0, 2}, {0.5, 0.25}),
            VoxelArray(std::vector<float>{0.25F, 1.25F}));
  EXPECT_EQ(read_telling<std::int32_t>(StoredType::kI32, {(1 << 24) + 1}).notes.size(), 1u);
  const Read nan = read_telling<double>(StoredType::kF64, {std::nan("")});
  EXPECT_TRUE(std::isnan(std::get<Voxels<float>>(nan.voxels)[0]));
  EXPECT_TRUE(nan.notes.empty());
}

TEST(StoredVoxels, what_a_narrow_type_does_not_hold_in_the_end_is_read_again_into_a_wider_one) {
  std::vector<std::int32_t> stored(200'000, 7);
  EXPECT_EQ(read_telling(StoredType::kI32, stored).passes, 1);
  stored.back() = 40'000;
  const Read as_unsigned = read_telling(StoredType::kI32, stored);
  EXPECT_EQ(as_unsigned.passes, 2);
  EXPECT_EQ(std::get<Voxels<std::uint16_t>>(as_unsigned.voxels)[199'999], 40'000);
  stored.back() = 70'000;
  const Read as_float = read_telling(StoredType::kI32, stored);
  EXPECT_EQ(as_float.passes, 3);
  EXPECT_EQ(std::get<Voxels<float>>(as_float.voxels)[199'999], 70'000);
}

TEST(StoredVoxels, a_promise_larger_than_the_file_or_the_memory_is_refused) {
  EXPECT_NO_THROW(check_promise("a", 100, 100, "raw"));
  EXPECT_THROW(check_promise("a", 101, 100, "raw"), WorkError);
  EXPECT_NO_THROW(check_promise("a", 1e5, 100, "gzip"));
  EXPECT_THROW(check_promise("a", 1e6, 100, "gzip"), WorkError);
  EXPECT_NO_THROW(check_promise("a", 1.1e9, 1e7, "gzip"));
  EXPECT_THROW(check_promise("a", 1.1e9, 5e6, "gzip"), WorkError);  // 220 : 1
  EXPECT_THROW(check_promise("a", std::nan(""), 1e18, "raw"), WorkError);
}

}  // namespace
}  // namespace isolux
