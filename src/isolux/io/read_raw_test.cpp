#include <gtest/gtest.h>

#include <fstream>

#include "isolux/base/error.h"
#include "isolux/base/memory.h"
#include "isolux/io/reader.h"
#include "temporary_folder.h"

namespace isolux {
namespace {

class LargeFiles : public TemporaryFolder {
 protected:
  // A sparse file, which takes no room on the disk: `before`, a hole, and `last` as its end.
  std::string sparse(const std::string& name, const std::string& before, std::uint64_t size,
                     const std::string& last) const {
    const std::string path = (folder_ / name).string();
    std::ofstream file(path, std::ios::binary);
    file << before;
    file.seekp(static_cast<std::streamoff>(size - last.size()));
    file << last;
    return path;
  }
};

const std::string kLastVoxel("\x34\x12", 2);  // 0x1234, little-endian
constexpr std::uint64_t kVoxelBytes = std::uint64_t{2048} * 2048 * 1024 * 2;  // 8 GiB

void expect_mapped(const Volume& volume, std::array<int, 3> dims) {
  EXPECT_EQ(volume.dims, dims);
  const auto& voxels = std::get<Voxels<std::int16_t>>(volume.voxels);
  ASSERT_EQ(voxels.size(), kVoxelBytes / 2);
  EXPECT_EQ(voxels[0], 0);
  EXPECT_EQ(voxels[kVoxelBytes / 2 - 1], 0x1234);
  EXPECT_TRUE(voxels.is_mapped());
  EXPECT_EQ(held_bytes(volume), 0u);
}

TEST_F(LargeFiles, eight_gibibytes_of_raw_voxels_open_without_being_read) {
  const std::string path = sparse("a.raw", "", kVoxelBytes, kLastVoxel);
  GridDescription grid;
  grid.dims = {2048, 2048, 1024};
  grid.type = "i16";
  expect_mapped(*read_input({path, grid}).volume, {2048, 2048, 1024});
  grid.dims = {2048, 2048, 1023};
  EXPECT_THROW(read_input({path, grid}), WorkError);
}

TEST_F(LargeFiles, eight_gibibytes_behind_a_header_open_without_being_read) {
  std::string nrrd =
      "NRRD0004\ntype: short\ndimension: 3\nsizes: 1024 2048 2048\nendian: little\n"
      "encoding: raw\n# padded to an even length\n";
  nrrd += nrrd.size() % 2 == 0 ? "# \n\n" : "\n";
  const std::string attached = sparse("a.nrrd", nrrd, nrrd.size() + kVoxelBytes, kLastVoxel);
  expect_mapped(*read_input({attached, {}}).volume, {1024, 2048, 2048});

  sparse("b.raw", "", 4 + kVoxelBytes, kLastVoxel);
  std::ofstream(folder_ / "b.nhdr")
      << "NRRD0004\ntype: short\ndimension: 3\nsizes: 4096 1024 1024\nendian: little\n"
         "encoding: raw\nbyte skip: -1\ndata file: b.raw\n";
  expect_mapped(*read_input({(folder_ / "b.nhdr").string(), {}}).volume, {4096, 1024, 1024});
  std::ofstream(folder_ / "b.mhd")
      << "NDims = 3\nDimSize = 2048 1024 2048\nElementType = MET_SHORT\n"
         "ElementByteOrderMSB = False\nHeaderSize = 4\nElementDataFile = b.raw\n";
  expect_mapped(*read_input({(folder_ / "b.mhd").string(), {}}).volume, {2048, 1024, 2048});
}

TEST_F(LargeFiles, a_header_that_promises_one_voxel_more_is_refused) {
  sparse("b.raw", "", kVoxelBytes - 2, "");
  std::ofstream(folder_ / "b.mhd")
      << "NDims = 3\nDimSize = 2048 1024 2048\nElementType = MET_SHORT\nElementDataFile = b.raw\n";
  EXPECT_THROW(read_input({(folder_ / "b.mhd").string(), {}}), WorkError);
}

TEST_F(LargeFiles, what_needs_conversion_or_lies_at_an_odd_place_is_read) {
  constexpr std::uint64_t kBytes = std::uint64_t{512} * 512 * 128 * 2;  // 64 MiB
  sparse("b.raw", "", kBytes + 1, kLastVoxel);
  for (const std::string fields : {"ElementByteOrderMSB = True\n", "HeaderSize = 1\n",
                                   "ElementToIntensityFunctionSlope = 2\n"}) {
    std::ofstream(folder_ / "b.mhd")
        << "NDims = 3\nDimSize = 512 512 128\n"
        << fields << "ElementType = MET_SHORT\nElementDataFile = b.raw\n";
    const auto result = read_input({(folder_ / "b.mhd").string(), {}});
    EXPECT_EQ(held_bytes(*result.volume), kBytes) << fields;
  }
}

TEST_F(LargeFiles, the_memory_limit_counts_all_inputs_that_are_kept) {
  const ReadResult first = read_input({"phantom:head,size=64", {}});  // 0.52 MB
  set_memory_limit(static_cast<double>(2 * held_bytes(*first.volume)));
  {
    const ReadResult second = read_input({"phantom:head,size=64", {}});
    EXPECT_THROW(read_input({"phantom:head,size=16", {}}), WorkError);
  }
  EXPECT_NO_THROW(read_input({"phantom:head,size=64", {}}));
  set_memory_limit(std::nullopt);
}

}  // namespace
}  // namespace isolux
