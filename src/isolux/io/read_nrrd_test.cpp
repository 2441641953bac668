#include <gtest/gtest.h>

#include <fstream>

#include "isolux/base/error.h"
#include "isolux/io/reader.h"
#include "temporary_folder.h"

namespace isolux {
namespace {

class Nrrd : public TemporaryFolder {
 protected:
  std::string written(const std::string& fields, const std::string& data) const {
    const std::string path = (folder_ / "a.nrrd").string();
    std::ofstream(path, std::ios::binary) << "NRRD0005\ndimension: 3\nsizes: 2 1 2\n"
                                          << fields << "\n"
                                          << data;
    return path;
  }
  ReadResult read(const std::string& fields, const std::string& data = "abcd") const {
    return read_input({written(fields, data), {}});
  }
  void expect_refused(const std::string& fields, const std::string& data, const char* why) const {
    try {
      read(fields, data);
      FAIL() << fields << data;
    } catch (const WorkError& error) {
      EXPECT_NE(std::string(error.what()).find(why), std::string::npos) << error.what();
    }
  }
};

const std::string kBytes = "type: uint8\nencoding: raw\n";

TEST_F(Nrrd, directions_and_origin_are_in_the_units_of_the_space) {
  const ReadResult result =
      read(kBytes +
           "space: RAS\nspace units: \"cm\" \"um\" \"in\"\n"
           "space directions: (1, 0, 0) (0,2000,0) (0,0,1)\nspace origin: (1,1000,2)\n");
  const Affine& affine = result.volume->world_from_index;
  // 1 cm to the right is 10 mm to -x; 2000 um to anterior 2 mm to -y; 1 in is 25.4 mm.
  EXPECT_EQ(affine.linear.column[0], (Vec3{-10, 0, 0}));
  EXPECT_EQ(affine.linear.column[1], (Vec3{0, -2, 0}));
  EXPECT_EQ(affine.linear.column[2], (Vec3{0, 0, 25.4}));
  EXPECT_EQ(affine.offset, (Vec3{-10, -1, 50.8}));
  EXPECT_EQ(result.notes.size(), 4u);  // RAS, and each of the three units
}

TEST_F(Nrrd, spacings_are_in_the_units_of_their_axes) {
  const ReadResult result = read(kBytes + "spacings: 5 2 nan\nunits: \"cm\" \"mm\" \"furlong\"\n");
  EXPECT_EQ(spacing_mm(*result.volume), (Vec3{50, 2, 1}));
}

TEST_F(Nrrd, numbers_as_text_are_read_in_their_type) {
  const std::string text = "encoding: text\ntype: ";
  EXPECT_EQ(read(text + "short\n", "-7 1\n2,\t3\n").volume->voxels,
            VoxelArray(std::vector<std::int16_t>{-7, 1, 2, 3}));
  EXPECT_EQ(read(text + "float\n", "1e2 0.5 -inf +3").volume->voxels,
            VoxelArray(std::vector<float>{100, 0.5F, -INFINITY, 3}));
  EXPECT_EQ(read(text + "int\n", "1 2 3 40000").volume->voxels,
            VoxelArray(std::vector<std::uint16_t>{1, 2, 3, 40000}));
  expect_refused(text + "uint8\n", "1 2 3 256", "256");
  expect_refused(text + "uint8\n", "1 2 3 x", "'x'");
  expect_refused(text + "uint8\n", "1 2       3", "numbers are missing");
}

TEST_F(Nrrd, hexadecimal_digits_are_bytes_in_the_order_of_the_header) {
  EXPECT_EQ(
      read("encoding: hex\ntype: short\nendian: big\n", "0001 0002\nfFfF 7fff").volume->voxels,
      VoxelArray(std::vector<std::int16_t>{1, 2, -1, 32767}));
  expect_refused("encoding: hex\ntype: uint8\n", "0102030g", "hexadecimal");
}

TEST_F(Nrrd, a_header_that_does_not_add_up_is_refused) {
  for (const char* line : {"kinds: domain domain\n", "spacings: 1 2\n", "spacings: 1 2 x\n",
                           "space directions: (1,0,0) (0,1,0)\n", "endian: middle\n",
                           "space directions: (1,0,0) (0,1,0) (0,0,1\n", "line skip: -1\n",
                           "space directions: (1,0,0) (0,1,0) up\n", "encoding: zip\n",
                           "space directions: (1,0,0) (0,x,0) (0,0,1)\n", "byte skip: -2\n"}) {
    expect_refused(kBytes + line, "abcd", "damaged NRRD header");
  }
  expect_refused(kBytes + "kinds: domain domain 3-color\n", "abcd", "2 values a voxel");
}

}  // namespace
}  // namespace isolux
