#include "isolux/io/write_volume.h"

#include <gtest/gtest.h>
#include <nifti/nifti1.h>

#include <cmath>
#include <cstddef>
#include <filesystem>
#include <fstream>

#include "isolux/base/error.h"
#include "isolux/io/reader.h"

namespace isolux {
namespace {

namespace fs = std::filesystem;

// An oblique, anisotropic, left-handed grid with every kind of value its type can hold.
template <typename T>
Volume oblique(std::vector<T> extremes) {
  Volume volume;
  volume.dims = {3, 4, 5};
  std::vector<T> voxels;
  for (std::size_t n = 0; n < 60; ++n) {
    voxels.push_back(n < extremes.size() ? extremes[n] : static_cast<T>(n * n % 251));
  }
  volume.voxels = std::move(voxels);
  volume.world_from_index = {
      {{{0.6 * 0.7, 0.8 * 0.7, 0}, {0.8 * 1.1, -0.6 * 1.1, 0}, {0, 0, 1.0 / 3}}},
      {-12.25, 100.0 / 7, 3e-3}};
  return volume;
}

class WriteVolume : public testing::TestWithParam<const char*> {
 protected:
  void SetUp() override {
    folder_ = fs::temp_directory_path() / ("isolux-write" + std::string(GetParam()));
    fs::remove_all(folder_);
    fs::create_directory(folder_);
  }
  void TearDown() override { fs::remove_all(folder_); }

  Volume written_and_read(const Volume& volume) const {
    const std::string path = (folder_ / ("a" + std::string(GetParam()))).string();
    write_volume(path, volume);
    return *read_input({path, {}}).volume;
  }
  // MetaImage keeps direction and spacing apart, and their product rounds.
  double tolerance() const { return std::string(GetParam()) == ".mha" ? 1e-15 : 0; }

  fs::path folder_;
};

TEST_P(WriteVolume, values_come_back_bit_for_bit) {
  const Volume volumes[] = {oblique<std::uint8_t>({0, 255}), oblique<std::int16_t>({-32768, 32767}),
                            oblique<std::uint16_t>({0, 65535}),
                            oblique<float>({1e-38F, -3e38F, INFINITY, 1.0F / 3})};
  for (const Volume& volume : volumes) {
    const Volume again = written_and_read(volume);
    EXPECT_EQ(again.dims, volume.dims);
    EXPECT_EQ(again.voxels, volume.voxels) << voxel_type_name(volume);
  }
}

TEST_P(WriteVolume, every_voxel_comes_back_where_it_was) {
  const Volume volume = oblique<std::uint8_t>({});
  const Volume again = written_and_read(volume);
  for (const Vec3 index : {Vec3{0, 0, 0}, Vec3{2, 0, 0}, Vec3{0, 3, 0}, Vec3{2, 3, 4}}) {
    const Vec3 was = volume.world_from_index.point(index);
    EXPECT_LE(length(again.world_from_index.point(index) - was), tolerance() * length(was));
  }
}

INSTANTIATE_TEST_SUITE_P(Formats, WriteVolume, testing::Values(".nrrd", ".mha", ".nii", ".nii.gz"),
                         [](const auto& one) {
                           std::string name = one.param;
                           std::erase(name, '.');
                           return name;
                         });

TEST(WriteNifti, floats_that_were_changed_count_more_than_the_full_numbers_beside_them) {
  const fs::path path = fs::temp_directory_path() / "isolux-changed.nii";
  write_volume(path.string(), oblique<std::uint8_t>({}));
  std::fstream file(path, std::ios::binary | std::ios::in | std::ios::out);
  const float moved = 5;
  file.seekp(offsetof(nifti_1_header, srow_z) + 3 * sizeof moved);
  file.write(reinterpret_cast<const char*>(&moved), sizeof moved);
  file.close();
  const Affine placed = read_input({path.string(), {}}).volume->world_from_index;
  EXPECT_EQ(placed.offset.z, 5);
  EXPECT_EQ(placed.offset.y, static_cast<double>(100.0F / 7));
  fs::remove(path);
}

TEST(WriteVolumeNames, another_ending_is_refused) {
  EXPECT_THROW(check_volume_name("a.png"), UsageError);
  EXPECT_THROW(check_volume_name("nrrd"), UsageError);
  EXPECT_NO_THROW(check_volume_name("a.b.nii.gz"));
}

}  // namespace
}  // namespace isolux
