#include "isolux/io/stored_voxels.h"

#include <gtest/gtest.h>

#include <cmath>

#include "isolux/base/error.h"

namespace isolux {
namespace {

template <typename Stored>
VoxelArray read(StoredType type, std::vector<Stored> stored, Rescale rescale = {}) {
  std::vector<std::string> notes;
  return voxels_from(type, stored.data(), stored.size(), rescale, notes);
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
  std::vector<std::string> notes;
  const std::int32_t large = (1 << 24) + 1;
  voxels_from(StoredType::kI32, &large, 1, {}, notes);
  EXPECT_EQ(notes.size(), 1u);
  const double nan = std::nan("");
  notes.clear();
  const VoxelArray voxels = voxels_from(StoredType::kF64, &nan, 1, {}, notes);
  EXPECT_TRUE(std::isnan(std::get<std::vector<float>>(voxels)[0]));
  EXPECT_TRUE(notes.empty());
}

TEST(StoredVoxels, a_promise_larger_than_the_file_or_the_memory_is_refused) {
  EXPECT_NO_THROW(check_promise("a", 100, 100, "raw"));
  EXPECT_THROW(check_promise("a", 101, 100, "raw"), WorkError);
  EXPECT_NO_THROW(check_promise("a", 1e5, 100, "gzip"));
  EXPECT_THROW(check_promise("a", 1e6, 100, "gzip"), WorkError);
  EXPECT_THROW(check_promise("a", 1e18, 1e18, "raw"), WorkError);
  EXPECT_NO_THROW(check_promise("a", 1.1e9, 1e7, "gzip"));
  EXPECT_THROW(check_promise("a", 1.1e9, 5e6, "gzip"), WorkError);  // 220 : 1
  EXPECT_THROW(check_promise("a", std::nan(""), 1e18, "raw"), WorkError);
}

}  // namespace
}  // namespace isolux
