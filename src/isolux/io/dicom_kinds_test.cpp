#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <limits>

#include "dicom_writer.h"
#include "isolux/base/error.h"
#include "isolux/base/number_text.h"
#include "isolux/io/reader.h"
#include "temporary_folder.h"

namespace isolux {
namespace {

// Kinds of DICOM files that no shared test file has, made here.
class DicomKinds : public TemporaryFolder {
 protected:
  ReadResult read(const DicomWriter& set) const {
    set.write(folder_ / "a");
    return read_input({(folder_ / "a").string(), {}});
  }
  void expect_refused(const DicomWriter& set, const char* why) const {
    try {
      read(set);
      FAIL() << why;
    } catch (const WorkError& error) {
      EXPECT_NE(std::string(error.what()).find(why), std::string::npos) << error.what();
    }
  }
};

std::string listed(std::initializer_list<double> numbers) {
  std::string text;
  for (const double number : numbers) text += (text.empty() ? "" : "\\") + to_text(number);
  return text;
}

// The start of an image of 2 x 1 pixels a frame.
DicomWriter image(const std::string& modality, const std::string& frames, int bits,
                  const std::string& photometric = "MONOCHROME2") {
  return DicomWriter()
      .text(0x08, 0x60, "CS", modality)
      .us(0x02, 1)
      .text(0x28, 0x04, "CS", photometric)
      .text(0x28, 0x08, "IS", frames)
      .us(0x10, 1)
      .us(0x11, 2)
      .us(0x100, bits)
      .us(0x101, bits)
      .us(0x102, bits - 1)
      .us(0x103, 0);
}

template <typename Number>
std::string bytes_of_numbers(const std::vector<Number>& numbers) {
  std::string bytes(numbers.size() * sizeof(Number), '\0');
  std::memcpy(bytes.data(), numbers.data(), bytes.size());
  return bytes;
}

TEST_F(DicomKinds, an_oblique_enhanced_ct_lies_where_its_frames_say) {
  // Rows run along a = (0.6, 0.8, 0), columns along b = (0, 0, -1); the normal is a x b =
  // (-0.8, 0.6, 0). Frame k lies at p + 2.5 k (a x b), frames written in the order 2, 0, 1.
  const Vec3 p{10, -20, 30}, a{0.6, 0.8, 0}, b{0, 0, -1}, normal = cross(a, b);
  const auto frame = [&](double k) {
    const Vec3 at = p + 2.5 * k * normal;
    return DicomWriter()
        .sequence(0x20, 0x9113, {DicomWriter().text(0x20, 0x32, "DS", listed({at.x, at.y, at.z}))})
        .sequence(0x20, 0x9116,
                  {DicomWriter().text(0x20, 0x37, "DS", listed({a.x, a.y, a.z, b.x, b.y, b.z}))})
        .sequence(0x28, 0x9110,
                  {DicomWriter()
                       .text(0x18, 0x50, "DS", "3")  // thicker than their distance
                       .text(0x28, 0x30, "DS", "0.5\\0.75")})
        .sequence(0x28, 0x9145,
                  {DicomWriter()
                       .text(0x28, 0x1052, "DS", "-1024")
                       .text(0x28, 0x1053, "DS", "1")
                       .text(0x28, 0x1054, "LO", "HU")});
  };
  const ReadResult result = read(image("CT", "3", 16)
                                     .sequence(0x5200, 0x9230, {frame(2), frame(0), frame(1)})
                                     .pixels({1020, 1021, 1000, 1001, 1010, 1011}));
  const Volume& volume = *result.volume;
  EXPECT_EQ(volume.dims, (std::array{2, 1, 3}));
  EXPECT_EQ(volume.units, "HU");
  EXPECT_EQ(volume.voxels, VoxelArray(std::vector<std::int16_t>{-24, -23, -14, -13, -4, -3}));
  for (int k = 0; k < 3; ++k) {
    for (int i = 0; i < 2; ++i) {
      const Vec3 expected = p + 0.75 * i * a + 2.5 * k * normal;
      const Vec3 found = volume.world_from_index.point({1.0 * i, 0, 1.0 * k});
      EXPECT_LT(length(found - expected), 1e-12) << i << " " << k;
    }
  }
  EXPECT_LT(length(volume.world_from_index.linear.column[1] - 0.5 * b), 1e-12);
}

DicomWriter dose(const std::string& offsets, const std::string& orientation) {
  return DicomWriter()
      .text(0x08, 0x60, "CS", "RTDOSE")
      .text(0x20, 0x32, "DS", "1\\2\\30")
      .text(0x20, 0x37, "DS", orientation)
      .us(0x02, 1)
      .text(0x28, 0x04, "CS", "MONOCHROME2")
      .text(0x28, 0x08, "IS", "3")
      .us(0x10, 1)
      .us(0x11, 2)
      .text(0x28, 0x30, "DS", "2\\2")
      .us(0x100, 32)
      .us(0x101, 32)
      .us(0x102, 31)
      .us(0x103, 0)
      .text(0x3004, 0x02, "CS", "GY")
      .text(0x3004, 0x0c, "DS", offsets)
      .text(0x3004, 0x0e, "DS", "0.25")
      .pixels("OW", 0x10, bytes_of_numbers<std::uint32_t>({1, 2, 3, 4, 5, 400'000}));
}

TEST_F(DicomKinds, a_dose_is_scaled_and_its_frames_lie_at_their_offsets) {
  const ReadResult result = read(dose("0\\2.5\\5", "1\\0\\0\\0\\1\\0"));
  EXPECT_EQ(result.volume->voxels,
            VoxelArray(std::vector<float>{0.25F, 0.5F, 0.75F, 1, 1.25F, 100'000}));
  EXPECT_EQ(result.volume->units, "GY");
  EXPECT_EQ(result.volume->world_from_index, (Affine{diagonal({2, 2, 2.5}), {1, 2, 30}}));
}

TEST_F(DicomKinds, offsets_of_a_dose_that_do_not_begin_at_0_are_the_frames_z) {
  const Affine expected{diagonal({2, 2, 2.5}), {1, 2, 30}};
  EXPECT_EQ(read(dose("30\\32.5\\35", "1\\0\\0\\0\\1\\0")).volume->world_from_index, expected);
  // Rows to -x turn the normal down; z still counts upward, so the last frame lies highest.
  const ReadResult down = read(dose("30\\32.5\\35", "-1\\0\\0\\0\\1\\0"));
  const Vec3 z_of_first = down.volume->world_from_index.point({0, 0, 0});
  const Vec3 z_of_last = down.volume->world_from_index.point({0, 0, 2});
  EXPECT_EQ(std::fabs(z_of_first.z - z_of_last.z), 5);
  EXPECT_EQ(std::fmin(z_of_first.z, z_of_last.z), 30);
}

TEST_F(DicomKinds, floating_point_pixels_are_read_as_they_are) {
  const ReadResult floats =
      read(image("MR", "1", 32)
               .pixels("OF", 0x08,
                       bytes_of_numbers<float>({-0.5F, std::numeric_limits<float>::infinity()})));
  EXPECT_EQ(floats.volume->voxels,
            VoxelArray(std::vector<float>{-0.5F, std::numeric_limits<float>::infinity()}));
  const ReadResult doubles =
      read(image("MR", "1", 64).pixels("OD", 0x09, bytes_of_numbers<double>({0.1, 3})));
  EXPECT_EQ(doubles.volume->voxels, VoxelArray(std::vector<float>{0.1F, 3}));
  expect_refused(image("MR", "2", 64).pixels("OD", 0x09, bytes_of_numbers<double>({0.1, 3})),
                 "bytes of pixels");
}

TEST_F(DicomKinds, colours_and_lookup_tables_are_refused_by_name) {
  expect_refused(image("US", "1", 16, "PALETTE COLOR").pixels({1, 2}), "PALETTE COLOR");
  expect_refused(image("CT", "1", 16)
                     .sequence(0x28, 0x3000, {DicomWriter().text(0x28, 0x3006, "OW", "abcd")})
                     .pixels({1, 2}),
                 "Modality LUT");
}

}  // namespace
}  // namespace isolux
