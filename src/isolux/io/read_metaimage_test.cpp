#include <gtest/gtest.h>
#include <zlib.h>

#include <algorithm>
#include <filesystem>
#include <fstream>

#include "isolux/base/error.h"
#include "isolux/io/data_file.h"
#include "isolux/io/reader.h"
#include "shared_data.h"
#include "temporary_folder.h"

namespace isolux {
namespace {

namespace fs = std::filesystem;

// The beginning of a header of 2 x 3 x 4 voxels.
const std::string kBegin = "ObjectType = Image\nNDims = 3\nDimSize = 2 3 4\n";

template <typename Number>
std::string numbers(std::size_t count, bool big_endian = false) {
  std::string bytes;
  for (std::size_t n = 0; n < count; ++n) {
    const auto number = static_cast<Number>(n);
    std::string text(reinterpret_cast<const char*>(&number), sizeof number);
    if (big_endian) std::reverse(text.begin(), text.end());
    bytes += text;
  }
  return bytes;
}

std::string deflated(const std::string& bytes) {
  uLongf length = compressBound(bytes.size());
  std::string out(length, '\0');
  compress(reinterpret_cast<Bytef*>(out.data()), &length,
           reinterpret_cast<const Bytef*>(bytes.data()), bytes.size());
  out.resize(length);
  return out;
}

ReadResult read_volume(const std::string& path, int number) {
  ReadRequest request{path, {}};
  request.grid.volume = number;
  return read_input(request);
}

double value(const Volume& volume, int i, int j, int k) {
  return visit_voxels(volume, [&](const auto& view) { return view.value(i, j, k); });
}

void expect_counting(const ReadResult& result) {
  const Volume& volume = *result.volume;
  ASSERT_EQ(volume.dims, (std::array<int, 3>{2, 3, 4}));
  for (int k = 0; k < 4; ++k) {
    for (int j = 0; j < 3; ++j) {
      for (int i = 0; i < 2; ++i) EXPECT_EQ(value(volume, i, j, k), i + 2 * (j + 3 * k));
    }
  }
}

bool has_note(const ReadResult& result, const std::string& part) {
  return std::ranges::any_of(
      result.notes, [&](const std::string& note) { return note.find(part) != std::string::npos; });
}

#define EXPECT_SAYS(text, part) EXPECT_NE((text).find(part), std::string::npos) << (text)

class ReadMetaImage : public TemporaryFolder {
 protected:
  std::string write(const std::string& name, const std::string& bytes) const {
    const fs::path path = folder_ / name;
    fs::create_directories(path.parent_path());
    std::ofstream(path, std::ios::binary) << bytes;
    return path.string();
  }
  ReadResult read_local(const std::string& header, const std::string& voxels) const {
    return read_input({write("a.mha", header + "ElementDataFile = LOCAL\n" + voxels), {}});
  }
  ReadResult read_bytes(const std::string& fields) const {
    return read_local(kBegin + "ElementType = MET_UCHAR\n" + fields, numbers<std::uint8_t>(24));
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
  std::string error_of_header(const std::string& header) const {
    return error_of(write("a.mha", header + numbers<std::uint8_t>(24)));
  }
};

TEST_F(ReadMetaImage, every_element_type_is_read_in_both_byte_orders) {
  const auto read_as = [&]<typename Number>(const std::string& type, Number) {
    const std::string header = kBegin + "ElementType = " + type + "\n";
    expect_counting(read_local(header, numbers<Number>(24)));
    expect_counting(read_local(header + "ElementByteOrderMSB = True\n", numbers<Number>(24, true)));
    expect_counting(
        read_local(header + "BinaryDataByteOrderMSB = True\n", numbers<Number>(24, true)));
  };
  read_as("MET_CHAR", std::int8_t{});
  read_as("MET_UCHAR", std::uint8_t{});
  read_as("MET_SHORT", std::int16_t{});
  read_as("MET_USHORT", std::uint16_t{});
  read_as("MET_INT", std::int32_t{});
  read_as("MET_UINT", std::uint32_t{});
  read_as("MET_LONG", std::int32_t{});  // four bytes, as MetaIO has it
  read_as("MET_ULONG", std::uint32_t{});
  read_as("MET_LONG_LONG", std::int64_t{});
  read_as("MET_ULONG_LONG", std::uint64_t{});
  read_as("MET_FLOAT", float{});
  read_as("MET_DOUBLE", double{});
}

TEST_F(ReadMetaImage, voxels_may_lie_in_one_file_a_list_or_a_numbered_series) {
  const std::string header = kBegin + "ElementType = MET_UCHAR\nElementDataFile = ";
  const std::string all = numbers<std::uint8_t>(24);
  write("all.raw", all);
  write("my data.raw", all);
  for (int k = 0; k < 4; ++k) {
    write("slices/s" + std::to_string(8 + k) + ".raw", all.substr(6 * k, 6));
    write("s" + std::string(k < 2 ? "00" : "0") + std::to_string(8 + k) + ".raw",
          all.substr(6 * k, 6));
    write("u" + std::to_string(10 - 3 * k) + ".raw", all.substr(6 * k, 6));
  }
  for (const std::string files :
       {"all.raw\n", "./all.raw\r\n", "my data.raw\n", "all.raw",
        "LIST\nslices/s8.raw\nslices/s9.raw\nslices/s10.raw\nslices/s11.raw\n",
        "LIST 2D\nslices/s8.raw\n\nslices/s9.raw\nslices/s10.raw\nslices/s11.raw",
        "LIST 3\nall.raw\n", "slices/s%d.raw 8 11 1\n", "s%03d.raw 8 11\n", "s%03d.raw 8\n",
        "u%d.raw 10 1 -3\n"}) {
    SCOPED_TRACE(files);
    expect_counting(read_input({write("a.mhd", header + files), {}}));
  }
  const ReadResult result = read_input({write("a.mhd", header + "s%03d.raw 8 11 1"), {}});
  EXPECT_EQ(result.files.size(), 5u);
}

TEST_F(ReadMetaImage, deflated_voxels_are_read_from_one_file_and_from_several) {
  const std::string all = numbers<std::uint8_t>(24);
  const std::string header = kBegin + "ElementType = MET_UCHAR\nCompressedData = True\n";
  expect_counting(read_local(header, deflated(all)));
  expect_counting(read_local(header + "CompressedDataSize = 32\n", deflated(all)));
  for (int k = 0; k < 4; ++k) write("s" + std::to_string(k), deflated(all.substr(6 * k, 6)));
  expect_counting(read_input({write("a.mhd", header + "ElementDataFile = s%d 0 3 1\n"), {}}));
  std::string broken = deflated(all);
  broken.resize(broken.size() - 10);
  EXPECT_SAYS(error_of(write("b.mha", header + "ElementDataFile = LOCAL\n" + broken)), "too early");
  std::string wrong = deflated(all);
  wrong.back() ^= 1;
  EXPECT_SAYS(error_of(write("b.mha", header + "ElementDataFile = LOCAL\n" + wrong)),
              "incorrect data check");
}

TEST_F(ReadMetaImage, a_header_size_skips_and_minus_one_counts_from_the_end) {
  const std::string header = kBegin + "ElementType = MET_UCHAR\n";
  write("a.raw", "seven..?" + numbers<std::uint8_t>(24));
  const std::string file = "ElementDataFile = a.raw\n";
  expect_counting(read_input({write("a.mhd", header + "HeaderSize = 8\n" + file), {}}));
  expect_counting(read_input({write("a.mhd", header + "HeaderSize = -1\n" + file), {}}));
  expect_counting(read_local(header + "HeaderSize = -1\n", numbers<std::uint8_t>(24)));
  for (const std::string size : {"9", "-2", "0.5", "1e20", "nan", "x", "33", "1000000"}) {
    EXPECT_FALSE(error_of(write("a.mhd", header + "HeaderSize = " + size + "\n" + file)).empty());
  }
  EXPECT_SAYS(error_of(write("a.mhd", header + "CompressedData = True\nHeaderSize = -1\n" + file)),
              "HeaderSize");
}

TEST_F(ReadMetaImage, row_i_of_the_matrix_is_the_direction_of_axis_i) {
  // As itk::MetaImageIO 5.2 reads the same header: axis 0 to +y, axis 1 to +z, axis 2 to +x.
  const ReadResult result = read_bytes(
      "TransformMatrix = 0 1 0 0 0 1 1 0 0\nPosition = 1 2 3\nOffset = 4 5 6e0\n"
      "ElementSize = 9 9 9\nElementSpacing = 2 3 4.0e+000\n");
  const Affine& placed = result.volume->world_from_index;
  EXPECT_EQ(placed, (Affine{{{{0, 2, 0}, {0, 0, 3}, {4, 0, 0}}}, {4, 5, 6}}));
}

TEST_F(ReadMetaImage, the_other_names_of_fields_mean_the_same) {
  const Affine placed{{{{-2, 0, 0}, {0, 3, 0}, {0, 0, 4}}}, {4, 5, 6}};
  for (const std::string matrix : {"TransformMatrix", "Rotation", "Orientation"}) {
    for (const std::string offset : {"Offset", "Position", "Origin"}) {
      const ReadResult result = read_bytes(matrix + " = -1 0 0 0 1 0 0 0 1\n" + offset +
                                           " : 4 5 6\n" + "ElementSize = 2 3 4\n");
      EXPECT_EQ(result.volume->world_from_index, placed);
    }
  }
}

TEST_F(ReadMetaImage, what_the_header_does_not_place_is_told) {
  EXPECT_TRUE(has_note(read_bytes(""), "taken as LPS"));
  const ReadResult result = read_bytes(
      "TransformMatrix = 1 0 0 0 1 0 0 0 1\nAnatomicalOrientation = LAS\nDistanceUnits = um\n"
      "Modality = MET_MOD_CT\n");
  EXPECT_EQ(result.volume->world_from_index, Affine{});
  EXPECT_EQ(result.volume->modality, "CT");
  EXPECT_TRUE(has_note(result, "AnatomicalOrientation"));
  EXPECT_TRUE(has_note(result, "'um'"));
  EXPECT_FALSE(has_note(result, "taken as LPS"));
}

TEST_F(ReadMetaImage, values_are_rescaled_where_the_header_says_so) {
  const ReadResult result =
      read_bytes("ElementToIntensityFunctionSlope = 2\nElementToIntensityFunctionOffset = -1000\n");
  EXPECT_EQ(value(*result.volume, 1, 2, 3), 2 * 23 - 1000);
}

TEST_F(ReadMetaImage, flat_files_and_files_of_several_volumes) {
  const ReadResult flat =
      read_local("NDims = 2\nDimSize = 6 4\nTransformMatrix = 0 1 1 0\nElementType = MET_UCHAR\n",
                 numbers<std::uint8_t>(24));
  EXPECT_EQ(flat.volume->dims, (std::array<int, 3>{6, 4, 1}));
  EXPECT_EQ(flat.volume->world_from_index.linear.column[0], (Vec3{0, 1, 0}));
  const std::string header = "NDims = 4\nDimSize = 2 3 1 4\nElementType = MET_UCHAR\n";
  const std::string voxels = numbers<std::uint8_t>(24);
  const std::string path = write("a.mha", header + "ElementDataFile = LOCAL\n" + voxels);
  const std::string packed = write(
      "b.mha", header + "CompressedData = True\nElementDataFile = LOCAL\n" + deflated(voxels));
  for (int n = 0; n < 4; ++n) write("s" + std::to_string(n), voxels.substr(6 * n, 6));
  const std::string listed = write("c.mhd", header + "ElementDataFile = s%d 0 3 1\n");
  for (const std::string& name : {path, packed, listed}) {
    const ReadResult result = read_volume(name, 2);
    EXPECT_EQ(result.volume_count, 4);
    EXPECT_EQ(value(*result.volume, 1, 2, 0), 17);
    EXPECT_THROW(read_volume(name, 4), UsageError);
  }
  EXPECT_EQ(read_volume(listed, 2).files,
            (std::vector<std::string>{listed, (folder_ / "s2").string()}));
}

TEST_F(ReadMetaImage, headers_that_make_no_sense_are_refused) {
  const std::string local = "ElementDataFile = LOCAL\n";
  const std::string bytes = "ElementType = MET_UCHAR\n";
  EXPECT_SAYS(error_of_header("NDims = 3\nDimSize = 2 3 4\n" + local), "ElementType ''");
  EXPECT_SAYS(error_of_header(kBegin + "ElementType = MET_STRING\n" + local), "MET_STRING");
  for (const std::string channels : {"0", "-1", "1.5", "1e99"}) {
    EXPECT_SAYS(
        error_of_header(kBegin + bytes + "ElementNumberOfChannels = " + channels + "\n" + local),
        "ElementNumberOfChannels");
  }
  EXPECT_SAYS(error_of_header(kBegin + bytes + "BinaryData = False\n" + local), "BinaryData");
  EXPECT_SAYS(error_of_header("ObjectType = Scene\nNDims = 3\n" + local), "'Scene'");
  EXPECT_SAYS(error_of_header(kBegin + bytes), "");
  for (const std::string axes : {"0", "-1", "5", "100", "2.5", "1e99", ""}) {
    EXPECT_SAYS(error_of_header("NDims = " + axes + "\nDimSize = 2 3 4\n" + bytes + local),
                "NDims");
  }
  for (const std::string sizes :
       {"2 3", "2 3 4 1", "2 3 0", "2 3 -4", "2 3 x", "2 3 4.5", "2 3 1e12", ""}) {
    EXPECT_SAYS(error_of_header("NDims = 3\nDimSize = " + sizes + "\n" + bytes + local), "DimSize");
  }
  // 2^90 and 2^64 voxels: 0 in 64 bits.
  for (const std::string sizes :
       {"100000 100000 100000", "1073741824 1073741824 1073741824", "4194304 2097152 2097152"}) {
    EXPECT_SAYS(error_of_header("NDims = 3\nDimSize = " + sizes + "\n" + bytes + local),
                "promises");
  }
  for (const std::string spacing : {"0 1 1", "-1 1 1"}) {
    EXPECT_SAYS(error_of_header(kBegin + bytes + "ElementSpacing = " + spacing + "\n" + local),
                "spacing");
  }
  EXPECT_SAYS(error_of_header(kBegin + bytes + "ElementSpacing = nan 1 1\n" + local), "'nan'");
  EXPECT_SAYS(error_of_header(kBegin + bytes + "TransformMatrix = 1 0 0 1 0 0 0 0 1\n" + local),
              "singular");
  EXPECT_SAYS(error_of_header(kBegin + bytes + "TransformMatrix = 1 0 0 0 1 0 0 0\n" + local),
              "8 numbers");
  EXPECT_SAYS(error_of_header(kBegin + bytes + "no field\n" + local), "no field");
}

TEST_F(ReadMetaImage, missing_short_and_miscounted_data_files_are_refused) {
  const std::string header = kBegin + "ElementType = MET_UCHAR\nElementDataFile = ";
  const auto error = [&](const std::string& files) {
    return error_of(write("a.mhd", header + files));
  };
  write("short.raw", "abc");
  for (int k = 0; k < 9; ++k) write("s" + std::to_string(k), "sixsix");
  EXPECT_SAYS(error("none.raw\n"), "none.raw");
  EXPECT_SAYS(error("short.raw\n"), "promises 24 bytes");
  EXPECT_SAYS(error("\n"), "beside or below");
  EXPECT_SAYS(error("LIST\ns1\ns2\n"), "names 2 data files, not the 4");
  EXPECT_SAYS(error("LIST\ns1\ns2\nshort.raw\ns4\n"), "short.raw");
  EXPECT_SAYS(error("s%d 0 8 1\n"), "names 9 data files, not the 4");
  for (const std::string pattern : {"s%s 0 3 1", "s%n 0 3 1", "s%1$d 0 3", "s%99d 0 3", "s%d 0 3 0",
                                    "s%d 3 0 1", "s%d 0 999999999999 1", "s%d a b c"}) {
    EXPECT_SAYS(error(pattern + "\n"), "is not understood");
  }
}

TEST_F(ReadMetaImage, a_header_names_only_files_beside_or_below_itself) {
  const std::string header = kBegin + "ElementType = MET_UCHAR\nElementDataFile = ";
  const std::string outside = write("outside.raw", numbers<std::uint8_t>(24));
  write("in/s/x.raw", numbers<std::uint8_t>(24));
  for (const std::string& files :
       {outside, std::string("../outside.raw"), std::string("s/../../outside.raw"),
        "LIST 3\n" + outside, std::string("LIST 3\n../outside.raw"),
        std::string("../s%d.raw 0 3 1")}) {
    EXPECT_SAYS(error_of(write("in/a.mhd", header + files + "\n")), "beside or below itself");
  }
  expect_counting(read_input({write("in/a.mhd", header + "s/x.raw\n"), {}}));
  const std::string nrrd =
      "NRRD0004\ntype: uchar\ndimension: 3\nsizes: 2 3 4\nencoding: raw\ndata file: ";
  EXPECT_SAYS(error_of(write("in/a.nhdr", nrrd + "../outside.raw\n")), "beside or below itself");
  EXPECT_SAYS(error_of(write("in/a.nhdr", nrrd + outside + "\n")), "beside or below itself");
  expect_counting(read_input({write("in/a.nhdr", nrrd + "s/x.raw\n"), {}}));
  fs::create_symlink(outside, folder_ / "in" / "away.raw");
  fs::create_symlink("s/x.raw", folder_ / "in" / "below.raw");
  EXPECT_SAYS(error_of(write("in/a.nhdr", nrrd + "away.raw\n")), "is a link to");
  expect_counting(read_input({write("in/a.nhdr", nrrd + "below.raw\n"), {}}));
}

TEST(DataFile, numbers_take_the_width_that_the_pattern_gives) {
  using Names = std::vector<std::string>;
  EXPECT_EQ(numbered_files("a%d.b", 9, 11, 1), (Names{"a9.b", "a10.b", "a11.b"}));
  EXPECT_EQ(numbered_files("%03d", 1, 5, 2), (Names{"001", "003", "005"}));
  EXPECT_EQ(numbered_files("%3d", 5, 1, -2), (Names{"  5", "  3", "  1"}));
  const long long huge = 9'223'372'036'854'775'807;
  EXPECT_TRUE(numbered_files("%d", -huge, huge, 1).empty());
  EXPECT_TRUE(numbered_files("%d", -huge, huge, huge).empty());
  EXPECT_TRUE(numbered_files("%d", 0, 10, 0).empty());
}

TEST(ReadSharedMetaImage, a_deflated_ct_lies_where_its_header_says) {
  ISOLUX_NEEDS("meta/3DCT_lung_baseline_small.mha");
  const ReadResult result = read_input({shared_data("meta/3DCT_lung_baseline_small.mha"), {}});
  EXPECT_EQ(result.volume->dims, (std::array<int, 3>{57, 78, 64}));
  EXPECT_EQ(result.volume->world_from_index,
            (Affine{diagonal({2.732, 2.732, 5}), {-152.461, -148.986, -1432}}));
  const auto& voxels = std::get<Voxels<std::int16_t>>(result.volume->voxels);
  EXPECT_GE(*std::ranges::min_element(voxels), -2048);  // Hounsfield units
  EXPECT_LE(*std::ranges::max_element(voxels), 4096);
}

TEST(ReadSharedMetaImage, a_header_without_object_type_is_read) {
  ISOLUX_NEEDS("meta/HeadMRVolume.mhd");
  const ReadResult result = read_input({shared_data("meta/HeadMRVolume.mhd"), {}});
  EXPECT_EQ(result.volume->dims, (std::array<int, 3>{48, 62, 42}));
  EXPECT_EQ(spacing_mm(*result.volume), (Vec3{4, 4, 4}));
  EXPECT_EQ(result.files.size(), 2u);
}

TEST(ReadSharedMetaImage, bad_files_are_refused) {
  ISOLUX_NEEDS("bad/mhd");
  for (const auto& entry : fs::directory_iterator(shared_data("bad/mhd"))) {
    EXPECT_THROW(read_input({entry.path().string(), {}}), WorkError) << entry.path();
  }
}

}  // namespace
}  // namespace isolux
