#include <gtest/gtest.h>
#include <nifti/nifti1.h>
#include <nifti/nifti2.h>
#include <zlib.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <limits>

#include "isolux/base/error.h"
#include "isolux/io/reader.h"
#include "isolux/io/stored_voxels.h"
#include "shared_data.h"
#include "temporary_folder.h"

namespace isolux {
namespace {

namespace fs = std::filesystem;

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();

// A header of 2 x 3 x 4 voxels of 16 bits, 1 x 2 x 3 mm, with nothing said of the patient.
template <typename Raw>
Raw plain_header() {
  Raw raw{};
  raw.sizeof_hdr = sizeof raw;
  const int dims[] = {3, 2, 3, 4, 1, 1, 1, 1};
  std::copy_n(dims, 8, raw.dim);
  raw.datatype = DT_INT16;
  raw.bitpix = 16;
  for (int axis = 0; axis < 4; ++axis) raw.pixdim[axis] = static_cast<float>(std::max(1, axis));
  raw.xyzt_units = NIFTI_UNITS_MM;
  if constexpr (sizeof raw == 348) {
    std::memcpy(raw.magic, "n+1\0", 4);
    raw.vox_offset = 352;
  } else {
    std::memcpy(raw.magic, "n+2\0\r\n\032\n", 8);
    raw.vox_offset = 544;
  }
  return raw;
}

nifti_1_header header1() { return plain_header<nifti_1_header>(); }

template <typename Raw>
void set_sform(Raw& raw, const Affine& ras) {
  raw.sform_code = 1;
  for (int column = 0; column < 4; ++column) {
    const Vec3 v = column < 3 ? ras.linear.column[column] : ras.offset;
    raw.srow_x[column] = static_cast<float>(v.x);
    raw.srow_y[column] = static_cast<float>(v.y);
    raw.srow_z[column] = static_cast<float>(v.z);
  }
}

// A quarter turn about z: the quaternion (cos 45 deg, 0, 0, sin 45 deg), so that i runs to +y.
template <typename Raw>
void set_quarter_turn(Raw& raw) {
  raw.qform_code = 1;
  raw.quatern_d = static_cast<float>(std::sqrt(0.5));
  raw.qoffset_x = 10;
  raw.qoffset_y = 20;
  raw.qoffset_z = 30;
}

template <typename Raw>
std::string bytes_of_header(const Raw& raw) {
  return {reinterpret_cast<const char*>(&raw), sizeof raw};
}

// The header with the bytes of its every number turned round, written down from nifti1.h: first
// byte, width, count.
std::string swapped_header_1(const nifti_1_header& raw) {
  std::string bytes = bytes_of_header(raw);
  const int fields[][3] = {{0, 4, 1},   {32, 4, 1},  {36, 2, 1},  {40, 2, 8},
                           {56, 4, 3},  {68, 2, 4},  {76, 4, 8},  {108, 4, 3},
                           {120, 2, 1}, {124, 4, 6}, {252, 2, 2}, {256, 4, 18}};
  for (const auto& [first, width, count] : fields) {
    for (int n = 0; n < count; ++n) {
      char* at = bytes.data() + first + n * width;
      std::reverse(at, at + width);
    }
  }
  return bytes;
}

// Likewise from nifti2.h.
std::string swapped_header_2(const nifti_2_header& raw) {
  std::string bytes = bytes_of_header(raw);
  const int fields[][3] = {{0, 4, 1},   {12, 2, 2},  {16, 8, 8},   {80, 8, 3}, {104, 8, 8},
                           {168, 8, 9}, {344, 4, 2}, {352, 8, 18}, {496, 4, 3}};
  for (const auto& [first, width, count] : fields) {
    for (int n = 0; n < count; ++n) {
      char* at = bytes.data() + first + n * width;
      std::reverse(at, at + width);
    }
  }
  return bytes;
}

template <typename Number>
std::string numbers(std::size_t count, bool swapped = false) {
  std::string bytes;
  for (std::size_t n = 0; n < count; ++n) {
    const auto number = static_cast<Number>(n);
    std::string text(reinterpret_cast<const char*>(&number), sizeof number);
    if (swapped) std::reverse(text.begin(), text.end());
    bytes += text;
  }
  return bytes;
}

ReadResult read_volume(const std::string& path, int number) {
  ReadRequest request{path, {}};
  request.grid.volume = number;
  return read_input(request);
}

double value(const Volume& volume, int i, int j, int k) {
  return visit_voxels(volume, [&](const auto& view) { return view.value(i, j, k); });
}

void expect_near(Vec3 a, Vec3 b, double tolerance = 1e-5) {
  EXPECT_NEAR(a.x, b.x, tolerance);
  EXPECT_NEAR(a.y, b.y, tolerance);
  EXPECT_NEAR(a.z, b.z, tolerance);
}

bool has_note(const ReadResult& result, const std::string& part) {
  return std::ranges::any_of(
      result.notes, [&](const std::string& note) { return note.find(part) != std::string::npos; });
}

class ReadNifti : public TemporaryFolder {
 protected:
  std::string write(const std::string& name, const std::string& bytes) const {
    const std::string path = (folder_ / name).string();
    std::ofstream(path, std::ios::binary) << bytes;
    return path;
  }
  std::string write_gz(const std::string& name, const std::string& bytes) const {
    const std::string path = (folder_ / name).string();
    gzFile file = gzopen(path.c_str(), "wb");
    gzwrite(file, bytes.data(), static_cast<unsigned>(bytes.size()));
    gzclose(file);
    return path;
  }
  template <typename Raw>
  std::string write_nii(const Raw& raw, const std::string& voxels) const {
    return write("a.nii", bytes_of_header(raw) + std::string(4, '\0') + voxels);
  }
  template <typename Raw>
  ReadResult read_nii(const Raw& raw, std::size_t voxels = 24) const {
    return read_input({write_nii(raw, numbers<std::int16_t>(voxels)), {}});
  }
  std::string error_of(const std::string& path) const {
    try {
      read_input({path, {}});
    } catch (const WorkError& error) {
      return error.what();
    }
    ADD_FAILURE() << path << " was read";
    return {};
  }
  template <typename Raw>
  std::string error_of_header(const Raw& raw) const {
    return error_of(write_nii(raw, numbers<std::int16_t>(24)));
  }
};

void expect_counting(const ReadResult& result) {
  const Volume& volume = *result.volume;
  ASSERT_EQ(volume.dims, (std::array<int, 3>{2, 3, 4}));
  for (int k = 0; k < 4; ++k) {
    for (int j = 0; j < 3; ++j) {
      for (int i = 0; i < 2; ++i) EXPECT_EQ(value(volume, i, j, k), i + 2 * (j + 3 * k));
    }
  }
}

#define EXPECT_SAYS(text, part) EXPECT_NE((text).find(part), std::string::npos) << (text)

TEST_F(ReadNifti, both_versions_and_both_byte_orders_give_the_same_voxels) {
  const std::string gap(4, '\0'), here = numbers<std::int16_t>(24),
                                  there = numbers<std::int16_t>(24, true);
  const auto raw1 = header1();
  const auto raw2 = plain_header<nifti_2_header>();
  const std::pair<std::string, std::string> files[] = {
      {"NIfTI-1", bytes_of_header(raw1) + gap + here},
      {"NIfTI-1", swapped_header_1(raw1) + gap + there},
      {"NIfTI-2", bytes_of_header(raw2) + gap + here},
      {"NIfTI-2", swapped_header_2(raw2) + gap + there}};
  for (const auto& [version, bytes] : files) {
    const ReadResult result = read_input({write("a.nii", bytes), {}});
    EXPECT_EQ(result.format, version);
    expect_counting(result);
    expect_near(spacing_mm(*result.volume), {1, 2, 3});
  }
}

TEST_F(ReadNifti, every_datatype_of_one_real_number_is_read) {
  const auto read_as = [&]<typename Number>(int datatype, Number) {
    auto raw = header1();
    raw.datatype = static_cast<short>(datatype);
    expect_counting(read_input({write_nii(raw, numbers<Number>(24)), {}}));
  };
  read_as(DT_UINT8, std::uint8_t{});
  read_as(DT_INT8, std::int8_t{});
  read_as(DT_INT16, std::int16_t{});
  read_as(DT_UINT16, std::uint16_t{});
  read_as(DT_INT32, std::int32_t{});
  read_as(DT_UINT32, std::uint32_t{});
  read_as(DT_INT64, std::int64_t{});
  read_as(DT_UINT64, std::uint64_t{});
  read_as(DT_FLOAT32, float{});
  read_as(DT_FLOAT64, double{});
}

TEST_F(ReadNifti, complex_numbers_and_unknown_types_are_refused) {
  for (const int datatype :
       {DT_COMPLEX64, DT_COMPLEX128, DT_COMPLEX256, DT_BINARY, DT_FLOAT128, 0, 7}) {
    auto raw = header1();
    raw.datatype = static_cast<short>(datatype);
    EXPECT_FALSE(error_of_header(raw).empty()) << datatype;
  }
}

TEST_F(ReadNifti, a_gzipped_file_is_known_by_content_whatever_its_name) {
  const std::string bytes =
      bytes_of_header(header1()) + std::string(4, '\0') + numbers<std::int16_t>(24);
  expect_counting(read_input({write_gz("a.nii.gz", bytes), {}}));
  expect_counting(read_input({write_gz("a.nii", bytes), {}}));
  expect_counting(read_input({write_gz("scan", bytes), {}}));
  expect_counting(read_input({write("plain", bytes), {}}));
}

TEST_F(ReadNifti, a_pair_is_opened_by_either_of_its_names_plain_or_gzipped) {
  auto raw = header1();
  std::memcpy(raw.magic, "ni1\0", 4);
  raw.vox_offset = 0;
  const std::string voxels = numbers<std::int16_t>(24);
  write("a.hdr", bytes_of_header(raw));
  write("a.img", voxels);
  write_gz("b.hdr.gz", bytes_of_header(raw));
  write_gz("b.img.gz", voxels);
  for (const std::string name : {"a.hdr", "a.img", "b.hdr.gz", "b.img.gz"}) {
    const ReadResult result = read_input({(folder_ / name).string(), {}});
    expect_counting(result);
    EXPECT_EQ(result.files.size(), 2u);
    EXPECT_EQ(result.name, (folder_ / name).string());
  }
  EXPECT_SAYS(error_of(write("alone.hdr", bytes_of_header(raw))), "no .img file");
}

TEST_F(ReadNifti, analyze_is_read_and_says_nothing_of_the_patient) {
  auto raw = header1();
  std::memset(raw.magic, 0, 4);
  raw.vox_offset = 0;
  raw.qform_code = raw.sform_code = 3;  // other fields stand here
  write("a.img", numbers<std::int16_t>(24));
  const ReadResult result = read_input({write("a.hdr", bytes_of_header(raw)), {}});
  EXPECT_EQ(result.format, "Analyze 7.5");
  expect_counting(result);
  EXPECT_TRUE(has_note(result, "does not say how it lies"));
  EXPECT_EQ(direction(*result.volume), Mat3{});
}

TEST_F(ReadNifti, without_forms_the_axes_are_taken_as_they_are) {
  const ReadResult result = read_nii(header1());
  EXPECT_EQ(result.volume->world_from_index, (Affine{diagonal({1, 2, 3}), {}}));
  EXPECT_TRUE(has_note(result, "does not say how it lies"));
}

TEST_F(ReadNifti, a_qform_turns_and_its_qfac_mirrors) {
  auto raw = header1();
  set_quarter_turn(raw);
  // In RAS i runs to +y, j to -x, k to +z; in LPS the first two rows change sign.
  const Affine placed = read_nii(raw).volume->world_from_index;
  expect_near(placed.linear.column[0], {0, -1, 0});
  expect_near(placed.linear.column[1], {2, 0, 0});
  expect_near(placed.linear.column[2], {0, 0, 3});
  expect_near(placed.offset, {-10, -20, 30});
  raw.pixdim[0] = -1;
  expect_near(read_nii(raw).volume->world_from_index.linear.column[2], {0, 0, -3});
}

TEST_F(ReadNifti, an_sform_is_kept_with_its_shear_and_its_handedness) {
  auto raw = header1();
  const Affine sheared{{{{-2, 0, 0}, {0.5, 3, 0}, {0, 0.25, 4}}}, {1, 2, 3}};
  set_sform(raw, sheared);
  const Affine placed = read_nii(raw).volume->world_from_index;
  expect_near(placed.linear.column[0], {2, 0, 0});
  expect_near(placed.linear.column[1], {-0.5, -3, 0});
  expect_near(placed.linear.column[2], {0, -0.25, 4});
  expect_near(placed.offset, {-1, -2, 3});
  EXPECT_LT(determinant(placed.linear), 0);
}

TEST_F(ReadNifti, the_sform_wins_and_a_qform_that_differs_is_told) {
  auto raw = header1();
  set_quarter_turn(raw);
  set_sform(raw, {{{{0, 1, 0}, {-2, 0, 0}, {0, 0, 3}}}, {10, 20, 30}});
  ReadResult result = read_nii(raw);
  EXPECT_TRUE(has_note(result, "by its sform"));
  EXPECT_FALSE(has_note(result, "mm from its sform"));
  // 3 voxels along k, each 0.05 mm longer: 0.15 mm at the far corner.
  raw.srow_z[2] = 3.05F;
  result = read_nii(raw);
  EXPECT_TRUE(has_note(result, "places some voxels 0.15"));
  expect_near(result.volume->world_from_index.linear.column[2], {0, 0, 3.05});
  raw.quatern_b = static_cast<float>(kNan);
  EXPECT_TRUE(has_note(read_nii(raw), "was left aside"));
}

TEST_F(ReadNifti, metres_and_microns_become_millimetres) {
  auto raw = header1();
  set_sform(raw, {Mat3{}, {1, 2, 3}});
  raw.xyzt_units = NIFTI_UNITS_METER;
  ReadResult result = read_nii(raw);
  expect_near(spacing_mm(*result.volume), {1000, 1000, 1000});
  expect_near(result.volume->world_from_index.offset, {-1000, -2000, 3000});
  raw.xyzt_units = NIFTI_UNITS_MICRON | NIFTI_UNITS_SEC;
  result = read_nii(raw);
  expect_near(spacing_mm(*result.volume), {1e-3, 1e-3, 1e-3}, 1e-12);
  EXPECT_TRUE(has_note(result, "microns"));
  raw.xyzt_units = 0;
  EXPECT_TRUE(has_note(read_nii(raw), "unit of length"));
}

TEST_F(ReadNifti, placements_that_place_nothing_are_refused) {
  auto raw = header1();
  for (const float spacing : {0.F, static_cast<float>(kNan), INFINITY}) {
    raw.pixdim[2] = spacing;
    EXPECT_SAYS(error_of_header(raw), "cannot be placed: its pixdim") << spacing;
  }
  raw = header1();
  set_quarter_turn(raw);
  raw.quatern_c = static_cast<float>(kNan);
  EXPECT_SAYS(error_of_header(raw), "its qform holds numbers that are not finite");
  raw = header1();
  set_sform(raw, {{{{1, 1, 0}, {1, 1, 0}, {0, 0, 1}}}, {}});
  EXPECT_SAYS(error_of_header(raw), "its sform is singular");
  set_sform(raw, {{{{0, 0, 0}, {1, 1, 0}, {0, 0, 1}}}, {}});
  EXPECT_SAYS(error_of_header(raw), "its sform gives an axis no length");
}

TEST_F(ReadNifti, slopes_rescale_and_zero_or_nan_mean_none) {
  auto raw = header1();
  raw.scl_slope = 0.5F;
  raw.scl_inter = -2;
  EXPECT_EQ(value(*read_nii(raw).volume, 1, 2, 3), 23 * 0.5 - 2);
  raw.scl_slope = 0;
  EXPECT_EQ(value(*read_nii(raw).volume, 1, 2, 3), 23);
  raw.scl_slope = static_cast<float>(kNan);
  const ReadResult result = read_nii(raw);
  EXPECT_EQ(value(*result.volume, 1, 2, 3), 23);
  EXPECT_TRUE(has_note(result, "scl_slope"));
  raw.scl_slope = INFINITY;
  EXPECT_SAYS(error_of_header(raw), "scl_slope");
  raw.scl_slope = 2;
  raw.scl_inter = static_cast<float>(kNan);
  EXPECT_SAYS(error_of_header(raw), "scl_inter");
}

TEST_F(ReadNifti, one_of_several_volumes_is_chosen_and_others_do_not_exist) {
  auto raw = header1();
  raw.dim[0] = 5;
  raw.dim[3] = 1;
  raw.dim[4] = 2;
  raw.dim[5] = 2;
  const std::string bytes = bytes_of_header(raw) + std::string(4, '\0') + numbers<std::int16_t>(24);
  for (const std::string& path : {write("a.nii", bytes), write_gz("a.nii.gz", bytes)}) {
    for (int n = 0; n < 4; ++n) {
      const ReadResult result = read_volume(path, n);
      EXPECT_EQ(result.volume_count, 4);
      EXPECT_EQ(value(*result.volume, 0, 0, 0), 6 * n);
      EXPECT_EQ(value(*result.volume, 1, 2, 0), 6 * n + 5);
    }
    EXPECT_EQ(value(*read_input({path, {}}).volume, 0, 0, 0), 0);
    EXPECT_THROW(read_volume(path, 4), UsageError);
    EXPECT_THROW(read_volume(path, -1), UsageError);
  }
}

TEST_F(ReadNifti, a_volume_that_is_there_is_read_though_later_ones_are_cut_off) {
  auto raw = header1();
  raw.dim[0] = 4;
  raw.dim[3] = 2;
  raw.dim[4] = 2;
  const std::string path = write_nii(raw, numbers<std::int16_t>(23));
  EXPECT_TRUE(has_note(read_input({path, {}}), "cut short"));
  EXPECT_THROW(read_volume(path, 1), WorkError);
}

TEST_F(ReadNifti, a_flat_file_is_one_slice) {
  auto raw = header1();
  raw.dim[0] = 2;
  raw.dim[3] = 99;  // beyond the file's own axes: not looked at
  raw.pixdim[3] = 0;
  const ReadResult result = read_nii(raw, 6);
  EXPECT_EQ(result.volume->dims, (std::array<int, 3>{2, 3, 1}));
  expect_near(spacing_mm(*result.volume), {1, 2, 1});
}

TEST_F(ReadNifti, headers_that_make_no_sense_are_refused) {
  const auto refused = [&](auto&& spoil, const char* part) {
    auto raw1 = header1();
    spoil(raw1);
    EXPECT_SAYS(error_of_header(raw1), part);
    auto raw2 = plain_header<nifti_2_header>();
    spoil(raw2);
    EXPECT_SAYS(error_of_header(raw2), part);
  };
  refused([](auto& raw) { raw.dim[0] = 0; }, "0 axes");
  refused([](auto& raw) { raw.dim[0] = 8; }, "8 axes");
  refused([](auto& raw) { raw.dim[0] = -3; }, "-3 axes");
  refused([](auto& raw) { raw.dim[1] = 0; }, "0 voxels long");
  refused([](auto& raw) { raw.dim[2] = -5; }, "-5 voxels long");
  refused([](auto& raw) { raw.vox_offset = -1; }, "vox_offset");
  refused([](auto& raw) { raw.vox_offset = 100; }, "vox_offset");
  refused([](auto& raw) { raw.vox_offset = 1 << 20; }, "only 0 bytes");
  refused([](auto& raw) { raw.sizeof_hdr = 0; }, "sizeof_hdr");
  refused([](auto& raw) { raw.dim[1] = raw.dim[2] = raw.dim[3] = 32767; }, "promises");
  refused(
      [](auto& raw) {
        raw.dim[0] = 7;
        std::fill(raw.dim + 1, raw.dim + 8, 32767);
      },
      "promises");
  auto raw = header1();
  raw.vox_offset = static_cast<float>(kNan);
  EXPECT_SAYS(error_of_header(raw), "vox_offset");
  auto raw2 = plain_header<nifti_2_header>();
  raw2.dim[1] = std::numeric_limits<std::int64_t>::max();
  EXPECT_SAYS(error_of_header(raw2), "too long");
  raw2.dim[0] = 7;
  raw2.dim[1] = 1;
  raw2.dim[4] = raw2.dim[5] = std::numeric_limits<std::int64_t>::max();
  EXPECT_SAYS(error_of_header(raw2), "promises");
}

TEST_F(ReadNifti, a_vox_offset_of_zero_means_behind_the_header) {
  auto raw = header1();
  raw.vox_offset = 0;
  const ReadResult result = read_nii(raw);
  expect_counting(result);
  EXPECT_TRUE(has_note(result, "vox_offset is 0"));
}

TEST_F(ReadNifti, truncated_files_are_refused_wherever_they_end) {
  const std::string bytes =
      bytes_of_header(header1()) + std::string(4, '\0') + numbers<std::int16_t>(24);
  for (const std::size_t length : {0u, 1u, 200u, 347u, 348u, 352u, 399u}) {
    EXPECT_FALSE(error_of(write("a.nii", bytes.substr(0, length))).empty());
    EXPECT_FALSE(error_of(write_gz("a.nii.gz", bytes.substr(0, length))).empty());
  }
  const std::string whole = write_gz("b.nii.gz", bytes);
  const auto size = fs::file_size(whole);
  fs::resize_file(whole, size - 12);
  EXPECT_SAYS(error_of(whole), "b.nii.gz");
}

TEST_F(ReadNifti, a_gzipped_file_with_a_wrong_checksum_is_refused) {
  const std::string path = write_gz(
      "a.nii.gz", bytes_of_header(header1()) + std::string(4, '\0') + numbers<std::int16_t>(24));
  std::fstream file(path, std::ios::binary | std::ios::in | std::ios::out);
  file.seekp(-8, std::ios::end);
  file.write("\1\2\3\4", 4);
  file.close();
  EXPECT_SAYS(error_of(path), "incorrect data check");
}

TEST_F(ReadNifti, a_small_gzipped_file_cannot_promise_much) {
  auto raw = header1();
  raw.dim[1] = raw.dim[2] = raw.dim[3] = 1000;
  EXPECT_SAYS(error_of(write_gz("a.nii.gz", bytes_of_header(raw))), "promises");
}

TEST(ReadSharedNifti, a_scan_is_the_same_as_nifti_and_as_nrrd) {
  ISOLUX_NEEDS("nifti/FLAIR.nii.gz");
  const ReadResult nifti = read_input({shared_data("nifti/FLAIR.nii.gz"), {}});
  const ReadResult nrrd = read_input({shared_data("nrrd/FLAIR.nrrd"), {}});
  EXPECT_EQ(nifti.volume->dims, nrrd.volume->dims);
  EXPECT_EQ(nifti.volume->voxels, nrrd.volume->voxels);
  const Affine &a = nifti.volume->world_from_index, &b = nrrd.volume->world_from_index;
  for (int axis = 0; axis < 3; ++axis) {
    expect_near(a.linear.column[axis], b.linear.column[axis], 1e-4);
  }
  expect_near(a.offset, b.offset, 1e-4);
}

TEST(ReadSharedNifti, one_head_stored_along_other_axes_lies_in_one_place) {
  ISOLUX_NEEDS("nifti/space/RAS.nii.gz");
  const ReadResult first = read_input({shared_data("nifti/space/RAS.nii.gz"), {}});
  const Volume& a = *first.volume;
  for (const std::string axes : {"LPS", "AIL", "PSR"}) {
    const ReadResult other = read_input({shared_data("nifti/space/" + axes + ".nii.gz"), {}});
    const Volume& b = *other.volume;
    const Affine b_from_a = [&] {
      const Affine back = inverse(b.world_from_index);
      return Affine{back.linear * a.world_from_index.linear, back.point(a.world_from_index.offset)};
    }();
    int differing = 0;
    double farthest = 0;
    for (int k = 0; k < a.dims[2]; ++k) {
      for (int j = 0; j < a.dims[1]; ++j) {
        for (int i = 0; i < a.dims[0]; ++i) {
          const Vec3 p = b_from_a.point({1. * i, 1. * j, 1. * k});
          const Vec3 at{std::round(p.x), std::round(p.y), std::round(p.z)};
          farthest = std::max(farthest, length(p - at));
          ASSERT_TRUE(at.x >= 0 && at.y >= 0 && at.z >= 0 && at.x < b.dims[0] && at.y < b.dims[1] &&
                      at.z < b.dims[2])
              << axes;
          differing += value(a, i, j, k) != value(b, static_cast<int>(at.x), static_cast<int>(at.y),
                                                  static_cast<int>(at.z));
        }
      }
    }
    EXPECT_EQ(differing, 0) << axes;
    EXPECT_LT(farthest, 1e-3) << axes;
  }
}

TEST(ReadSharedNifti, a_big_endian_file_with_a_negative_column_keeps_it) {
  ISOLUX_NEEDS("nifti/anatomical.nii");
  const ReadResult result = read_input({shared_data("nifti/anatomical.nii"), {}});
  EXPECT_EQ(result.volume->dims, (std::array<int, 3>{33, 41, 25}));
  expect_near(spacing_mm(*result.volume), {2, 2, 2});
  // LAS: i runs to the left (+x in LPS), j to anterior (-y), k to superior.
  const Mat3 unit = direction(*result.volume);
  expect_near(unit.column[0], {1, 0, 0});
  expect_near(unit.column[1], {0, -1, 0});
  expect_near(unit.column[2], {0, 0, 1});
}

TEST(ReadSharedNifti, twenty_volumes_are_rescaled_each) {
  ISOLUX_NEEDS("nifti/functional.nii");
  const std::string path = shared_data("nifti/functional.nii");
  const ReadResult first = read_input({path, {}}), last = read_volume(path, 19);
  EXPECT_EQ(first.volume_count, 20);
  EXPECT_EQ(first.volume->dims, (std::array<int, 3>{17, 21, 3}));
  EXPECT_NE(first.volume->voxels, last.volume->voxels);
  EXPECT_THROW(read_volume(path, 20), UsageError);
  std::ifstream file(path, std::ios::binary);
  file.seekg(352 + 19 * 17 * 21 * 3 * 2);
  std::int16_t stored = 0;
  file.read(reinterpret_cast<char*>(&stored), sizeof stored);
  EXPECT_NEAR(value(*last.volume, 0, 0, 0), 0.0754 * stored + 3100.76, 0.0001 * std::abs(stored));
}

TEST(ReadSharedNifti, bad_files_are_refused) {
  ISOLUX_NEEDS("bad/nifti");
  for (const auto& entry : fs::directory_iterator(shared_data("bad/nifti"))) {
    EXPECT_THROW(read_input({entry.path().string(), {}}), WorkError) << entry.path();
  }
}

}  // namespace
}  // namespace isolux
