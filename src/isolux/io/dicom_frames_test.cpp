#include <gtest/gtest.h>
#include <sys/resource.h>

#include <bit>
#include <cstdlib>

#include "dicom_writer.h"
#include "isolux/base/error.h"
#include "isolux/io/reader.h"
#include "temporary_folder.h"

namespace isolux {
namespace {

// Files of several encoded frames, each frame one piece or several.
class DicomFrames : public TemporaryFolder {
 protected:
  std::string written(int columns, int rows, std::size_t frames, const std::string& syntax,
                      const std::vector<std::string>& pieces,
                      const std::vector<std::uint32_t>& offsets = {}) const {
    const std::string path = (folder_ / "a").string();
    DicomWriter()
        .text(0x08, 0x60, "CS", "CT")
        .us(0x02, 1)
        .text(0x28, 0x04, "CS", "MONOCHROME2")
        .text(0x28, 0x08, "IS", std::to_string(frames))
        .us(0x10, rows)
        .us(0x11, columns)
        .us(0x100, 16)
        .us(0x101, 16)
        .us(0x102, 15)
        .us(0x103, 0)
        .encoded(pieces, offsets)
        .write(path, syntax);
    return path;
  }
};

constexpr const char* kRle = "1.2.840.10008.1.2.5";
constexpr const char* kJpegLossless = "1.2.840.10008.1.2.4.70";

VoxelArray voxels_of(const std::string& path) { return read_input({path, {}}).volume->voxels; }

// A frame of two pixels in RLE: a header of 64 bytes, then the upper and the lower bytes, each as a
// literal run of two.
std::string run_lengths(int first, int second) {
  std::string bytes(64, '\0');
  bytes[0] = 2;   // segments
  bytes[4] = 64;  // where they begin
  bytes[8] = 68;
  for (const int shift : {8, 0}) {
    bytes += std::string{1, static_cast<char>(first >> shift), static_cast<char>(second >> shift),
                         '\x80'};  // 1: two bytes follow; 0x80: nothing
  }
  return bytes;
}

// Bits, highest first, as JPEG has them: a zero byte follows 0xff.
class JpegBits {
 public:
  void add(unsigned value, int count) {
    for (int bit = count - 1; bit >= 0; --bit) {
      byte_ = byte_ << 1 | (value >> bit & 1);
      if (++filled_ < 8) continue;
      bytes_ += static_cast<char>(byte_);
      if (byte_ == 0xff) bytes_ += '\0';
      byte_ = 0;
      filled_ = 0;
    }
  }
  std::string bytes() {
    while (filled_ != 0) add(1, 1);
    return bytes_;
  }

 private:
  std::string bytes_;
  unsigned byte_ = 0;
  int filled_ = 0;
};

// A picture in lossless JPEG (ITU-T T.81, process 14, selection value 1): each pixel by its
// difference from the one before it, the first of a row from the one above, the very first from
// 2^15. A difference of n bits comes as the number n, in a code of 5 bits, and its bits.
std::string lossless_jpeg(int columns, int rows, const std::vector<int>& pixels) {
  const auto two = [](int number) {
    return std::string{static_cast<char>(number >> 8), static_cast<char>(number)};
  };
  std::string picture = "\xff\xd8";
  picture +=
      "\xff\xc3" + two(11) + '\x10' + two(rows) + two(columns) + std::string("\1\1\x11\0", 4);
  picture +=
      "\xff\xc4" + two(2 + 17 + 16) + std::string("\0\0\0\0\0\x10", 6) + std::string(11, '\0');
  for (char n = 0; n < 16; ++n) picture += n;
  picture += "\xff\xda" + two(8) + std::string("\1\1\0\1\0\0", 6);
  JpegBits bits;
  for (int n = 0; n < columns * rows; ++n) {
    const auto at = [&](int pixel) { return pixels[static_cast<std::size_t>(pixel)]; };
    const int expected = n == 0 ? 1 << 15 : n % columns == 0 ? at(n - columns) : at(n - 1);
    const int difference = at(n) - expected;
    const int width = static_cast<int>(std::bit_width(static_cast<unsigned>(std::abs(difference))));
    bits.add(static_cast<unsigned>(width), 5);
    bits.add(static_cast<unsigned>(difference < 0 ? difference - 1 : difference), width);
  }
  picture += bits.bytes() + "\xff\xd9";
  return picture.size() % 2 == 0 ? picture : picture + '\0';
}

std::vector<std::string> in_two(const std::string& bytes) {
  const std::size_t half = bytes.size() / 4 * 2;
  return {bytes.substr(0, half), bytes.substr(half)};
}

TEST_F(DicomFrames, are_decoded_one_at_a_time_and_a_damaged_one_is_told) {
  const auto of_three = [&](const std::string& second) {
    return written(2, 1, 3, kRle, {run_lengths(1, 2), second, run_lengths(5, 777)});
  };
  EXPECT_EQ(voxels_of(of_three(run_lengths(3, 4))),
            VoxelArray(std::vector<std::uint16_t>{1, 2, 3, 4, 5, 777}));
  EXPECT_THROW(voxels_of(of_three("no run lengths at all, but 40 bytes of text")), WorkError);
}

TEST_F(DicomFrames, beyond_what_is_read_at_a_stroke_each_lie_in_their_place) {
  std::vector<std::string> pieces;
  std::vector<std::uint16_t> expected;
  for (int n = 0; n < 100; ++n) {
    pieces.push_back(run_lengths(n, 2 * n));
    expected.push_back(static_cast<std::uint16_t>(n));
    expected.push_back(static_cast<std::uint16_t>(2 * n));
  }
  EXPECT_EQ(voxels_of(written(2, 1, 100, kRle, pieces)), VoxelArray(expected));
}

TEST_F(DicomFrames, in_several_pieces_begin_where_the_table_of_offsets_or_a_picture_does) {
  const std::vector<std::string> first = in_two(lossless_jpeg(2, 1, {32768, 32771})),
                                 second = in_two(lossless_jpeg(2, 1, {40000, 20005}));
  const std::vector<std::string> pieces{first[0], first[1], second[0], second[1]};
  const VoxelArray expected(std::vector<std::uint16_t>{32768, 32771, 40000, 20005});
  EXPECT_EQ(voxels_of(written(2, 1, 2, kJpegLossless, pieces)), expected);
  // Each piece has a head of 8 bytes.
  const auto behind_first = static_cast<std::uint32_t>(first[0].size() + first[1].size() + 16);
  EXPECT_EQ(voxels_of(written(2, 1, 2, kJpegLossless, pieces, {0, behind_first})), expected);
  EXPECT_EQ(voxels_of(written(2, 1, 2, kJpegLossless, pieces, {0, 3})), expected)
      << "a wrong table";
  // Run lengths do not tell where they begin, so there the table alone does.
  const std::vector<std::string> runs = in_two(run_lengths(7, 8));
  EXPECT_EQ(voxels_of(written(2, 1, 2, kRle, {run_lengths(1, 2), runs[0], runs[1]}, {0, 80})),
            VoxelArray(std::vector<std::uint16_t>{1, 2, 7, 8}));
  EXPECT_THROW(voxels_of(written(2, 1, 2, kRle, {run_lengths(1, 2), runs[0], runs[1]})), WorkError);
  EXPECT_THROW(voxels_of(written(2, 1, 2, kRle, {run_lengths(1, 2)})), WorkError);
}

#if !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__)

long most_kilobytes(__rusage_who who) {
  rusage usage{};
  ::getrusage(who, &usage);
  return usage.ru_maxrss;
}

TEST_F(DicomFrames, in_several_pieces_are_never_whole_in_a_child) {
  constexpr int kWidth = 512, kFrames = 80;  // 42 MB of voxels, a third of a megabyte for a piece
  const std::vector<std::string> picture =
      in_two(lossless_jpeg(kWidth, kWidth, std::vector<int>(kWidth * kWidth, 1000)));
  std::vector<std::string> pieces;
  for (int n = 0; n < kFrames; ++n) pieces.insert(pieces.end(), picture.begin(), picture.end());
  const std::string path = written(kWidth, kWidth, kFrames, kJpegLossless, pieces);
  pieces.clear();
  const long before = most_kilobytes(RUSAGE_SELF);
  EXPECT_EQ(voxels_of(path),
            VoxelArray(std::vector<std::uint16_t>(kFrames * kWidth * kWidth, 1000)));
  const long voxels = kFrames * kWidth * kWidth * 2 / 1024;
  EXPECT_LT(most_kilobytes(RUSAGE_CHILDREN), before + voxels / 4);
}

#endif

}  // namespace
}  // namespace isolux
