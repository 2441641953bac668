#include <gtest/gtest.h>
#include <tiffio.h>

#include <filesystem>
#include <fstream>
#include <memory>

#include "isolux/base/error.h"
#include "isolux/io/reader.h"
#include "temporary_folder.h"

namespace isolux {
namespace {

namespace fs = std::filesystem;

// A page whose sample n is `first + n`, in rows of `width`.
template <typename T>
void write_page(TIFF* tiff, int width, int height, int first, int samples, bool tiled, int format) {
  TIFFSetField(tiff, TIFFTAG_IMAGEWIDTH, width);
  TIFFSetField(tiff, TIFFTAG_IMAGELENGTH, height);
  TIFFSetField(tiff, TIFFTAG_BITSPERSAMPLE, 8 * static_cast<int>(sizeof(T)));
  TIFFSetField(tiff, TIFFTAG_SAMPLEFORMAT, format);
  TIFFSetField(tiff, TIFFTAG_SAMPLESPERPIXEL, samples);
  TIFFSetField(tiff, TIFFTAG_PLANARCONFIG, PLANARCONFIG_CONTIG);
  TIFFSetField(tiff, TIFFTAG_PHOTOMETRIC, samples == 3 ? PHOTOMETRIC_RGB : PHOTOMETRIC_MINISBLACK);
  TIFFSetField(tiff, TIFFTAG_COMPRESSION, COMPRESSION_LZW);
  if (tiled) {
    TIFFSetField(tiff, TIFFTAG_TILEWIDTH, 16);
    TIFFSetField(tiff, TIFFTAG_TILELENGTH, 16);
    for (int y = 0; y < height; y += 16) {
      for (int x = 0; x < width; x += 16) {
        std::vector<T> tile(256);
        for (int n = 0; n < 256; ++n) {
          const int value = first + (y + n / 16) * width + x + n % 16;
          tile[static_cast<std::size_t>(n)] = static_cast<T>(value);
        }
        TIFFWriteTile(tiff, tile.data(), x, y, 0, 0);
      }
    }
  } else {
    for (int y = 0; y < height; ++y) {
      std::vector<T> row(static_cast<std::size_t>(width * samples));
      for (std::size_t x = 0; x < row.size(); ++x) {
        row[x] = static_cast<T>(first + y * width * samples + static_cast<int>(x));
      }
      TIFFWriteScanline(tiff, row.data(), y, 0);
    }
  }
  TIFFWriteDirectory(tiff);
}

class TiffReader : public TemporaryFolder {
 protected:
  // Pages of 20 x 18 whose values go on from page to page.
  template <typename T>
  std::string stack(const std::string& name, int pages, const char* mode = "w", int samples = 1,
                    bool tiled = false, int format = SAMPLEFORMAT_UINT) {
    const std::string path = (folder_ / name).string();
    const std::unique_ptr<TIFF, decltype(&TIFFClose)> tiff(TIFFOpen(path.c_str(), mode), TIFFClose);
    for (int page = 0; page < pages; ++page) {
      write_page<T>(tiff.get(), 20, 18, 360 * page, samples, tiled, format);
    }
    return path;
  }

  static ReadResult read(const std::string& path) { return read_input({path, {}}); }
};

template <typename T>
std::vector<T> counted(int count) {
  std::vector<T> values;
  for (int n = 0; n < count; ++n) values.push_back(static_cast<T>(n));
  return values;
}

TEST_F(TiffReader, the_pages_of_a_file_are_its_slices) {
  for (const char* mode : {"wl", "wb", "wl8", "wb8"}) {  // both byte orders, classic and BigTIFF
    const ReadResult result = read(stack<std::uint16_t>("a.tif", 3, mode));
    EXPECT_EQ(result.volume->dims, (std::array{20, 18, 3}));
    EXPECT_EQ(result.volume->voxels, VoxelArray(counted<std::uint16_t>(20 * 18 * 3))) << mode;
  }
}

TEST_F(TiffReader, tiles_and_other_number_types_are_read) {
  EXPECT_EQ(read(stack<std::uint16_t>("a.tif", 2, "w", 1, true)).volume->voxels,
            VoxelArray(counted<std::uint16_t>(20 * 18 * 2)));
  EXPECT_EQ(read(stack<std::int16_t>("b.tif", 1, "w", 1, false, SAMPLEFORMAT_INT)).volume->voxels,
            VoxelArray(counted<std::int16_t>(360)));
  EXPECT_EQ(read(stack<float>("c.tif", 1, "w", 1, true, SAMPLEFORMAT_IEEEFP)).volume->voxels,
            VoxelArray(counted<float>(360)));
}

TEST_F(TiffReader, colours_become_their_luma_and_that_is_told) {
  const ReadResult result = read(stack<std::uint8_t>("a.tif", 1, "w", 3));
  EXPECT_EQ(voxel_type_name(*result.volume), "u8");
  // The first pixel is (0, 1, 2): 0.7152 + 2 * 0.0722 = 0.8596, which is 1.
  EXPECT_EQ(std::get<Voxels<std::uint8_t>>(result.volume->voxels)[0], 1);
  EXPECT_EQ(std::get<Voxels<std::uint8_t>>(result.volume->voxels).size(), 360u);
  EXPECT_FALSE(result.notes.empty());
}

TEST_F(TiffReader, a_folder_is_a_stack_in_natural_order) {
  for (const int page : {10, 9, 2, 1}) {
    const std::string path = (folder_ / ("s" + std::to_string(page) + ".tif")).string();
    const std::unique_ptr<TIFF, decltype(&TIFFClose)> tiff(TIFFOpen(path.c_str(), "w"), TIFFClose);
    write_page<std::uint16_t>(tiff.get(), 20, 18, page, 1, false, SAMPLEFORMAT_UINT);
  }
  const ReadResult result = read(folder_.string());
  ASSERT_EQ(result.volume->dims, (std::array{20, 18, 4}));
  const auto& voxels = std::get<Voxels<std::uint16_t>>(result.volume->voxels);
  EXPECT_EQ((std::array{voxels[0], voxels[360], voxels[720], voxels[1080]}),
            (std::array<std::uint16_t, 4>{1, 2, 9, 10}));
}

TEST_F(TiffReader, every_cut_is_an_error_or_fewer_pages_and_never_a_crash) {
  std::ifstream file(stack<std::uint16_t>("whole.tif", 2), std::ios::binary);
  const std::string bytes((std::istreambuf_iterator<char>(file)), {});
  for (std::size_t length = 4; length < bytes.size(); length += 7) {
    const fs::path cut = folder_ / "cut.tif";
    std::ofstream(cut, std::ios::binary) << bytes.substr(0, length);
    try {
      EXPECT_LE(read(cut.string()).volume->dims[2], 2);
    } catch (const WorkError&) {
    }
  }
}

}  // namespace
}  // namespace isolux
