#include <tiffio.h>

#include <algorithm>
#include <cstring>
#include <filesystem>
#include <memory>
#include <optional>

#include "isolux/base/error.h"
#include "isolux/base/memory.h"
#include "isolux/base/number_text.h"
#include "isolux/io/channels.h"
#include "isolux/io/format.h"
#include "isolux/io/natural_order.h"
#include "isolux/io/read_fenced.h"
#include "isolux/io/stored_voxels.h"

// TIFF by libtiff, inside a fence: the pages of one file, or the files of one folder in natural
// order of their names, are the slices along k.

namespace isolux {
namespace {

namespace fs = std::filesystem;
using TiffPointer = std::unique_ptr<TIFF, decltype(&TIFFClose)>;

WorkError damaged(const std::string& path, const std::string& why) {
  return {path, "cannot be read as TIFF: " + why, "is the file complete?"};
}

// What all pages of a stack must share.
struct PageLayout {
  std::uint32_t width = 0;
  std::uint32_t height = 0;
  std::uint16_t samples = 1;  ///< per pixel: 1 grey, 3 or 4 colour
  std::uint16_t photometric = PHOTOMETRIC_MINISBLACK;
  StoredType type = StoredType::kU8;

  bool operator==(const PageLayout&) const = default;
  std::size_t row_bytes() const { return std::size_t{width} * samples * bytes_of(type); }
  double bytes() const { return static_cast<double>(row_bytes()) * height; }
};

std::optional<StoredType> stored_type(std::uint16_t bits, std::uint16_t format) {
  const bool is_float = format == SAMPLEFORMAT_IEEEFP;
  const bool is_signed = format == SAMPLEFORMAT_INT;
  if (format == SAMPLEFORMAT_COMPLEXINT || format == SAMPLEFORMAT_COMPLEXIEEEFP) return {};
  switch (bits) {
    case 8:
      if (is_float) return {};
      return is_signed ? StoredType::kI8 : StoredType::kU8;
    case 16:
      if (is_float) return {};
      return is_signed ? StoredType::kI16 : StoredType::kU16;
    case 32:
      return is_float ? StoredType::kF32 : is_signed ? StoredType::kI32 : StoredType::kU32;
    case 64:
      return is_float ? StoredType::kF64 : is_signed ? StoredType::kI64 : StoredType::kU64;
    default:
      return {};
  }
}

TiffPointer open_tiff(const std::string& path) {
  TIFFSetErrorHandler(nullptr);  // what goes wrong is told by exceptions
  TIFFSetWarningHandler(nullptr);
  TiffPointer tiff(TIFFOpen(path.c_str(), "rm"), TIFFClose);
  if (!tiff) throw damaged(path, "its first page cannot be found");
  return tiff;
}

PageLayout page_layout(TIFF& tiff, const std::string& path) {
  PageLayout layout;
  std::uint16_t bits = 1, format = SAMPLEFORMAT_UINT, planar = PLANARCONFIG_CONTIG;
  TIFFGetField(&tiff, TIFFTAG_IMAGEWIDTH, &layout.width);
  TIFFGetField(&tiff, TIFFTAG_IMAGELENGTH, &layout.height);
  TIFFGetFieldDefaulted(&tiff, TIFFTAG_BITSPERSAMPLE, &bits);
  TIFFGetFieldDefaulted(&tiff, TIFFTAG_SAMPLEFORMAT, &format);
  TIFFGetFieldDefaulted(&tiff, TIFFTAG_SAMPLESPERPIXEL, &layout.samples);
  TIFFGetFieldDefaulted(&tiff, TIFFTAG_PLANARCONFIG, &planar);
  TIFFGetField(&tiff, TIFFTAG_PHOTOMETRIC, &layout.photometric);
  std::uint16_t compression = COMPRESSION_NONE;
  TIFFGetFieldDefaulted(&tiff, TIFFTAG_COMPRESSION, &compression);
  if (layout.photometric == PHOTOMETRIC_YCBCR && compression == COMPRESSION_JPEG) {
    TIFFSetField(&tiff, TIFFTAG_JPEGCOLORMODE, JPEGCOLORMODE_RGB);
    layout.photometric = PHOTOMETRIC_RGB;
  }
  constexpr std::uint32_t kLargest = 1 << 20;
  if (layout.width < 1 || layout.height < 1 || layout.width > kLargest ||
      layout.height > kLargest) {
    throw damaged(path, "a page of " + std::to_string(layout.width) + " x " +
                            std::to_string(layout.height) + " pixels");
  }
  const auto type = stored_type(bits, format);
  if (!type) {
    throw WorkError(path, "has " + std::to_string(bits) + " bits a sample of a kind not read here",
                    "save it with 8, 16 or 32 bits");
  }
  layout.type = *type;
  const bool is_grey = layout.samples == 1 || layout.samples == 2;
  const bool is_colour = layout.samples == 3 || layout.samples == 4;
  if ((!is_grey && !is_colour) || (layout.samples > 1 && planar != PLANARCONFIG_CONTIG)) {
    throw WorkError(path, "has " + std::to_string(layout.samples) + " values a pixel",
                    "isolux draws surfaces of one value; extract a channel first");
  }
  if (is_colour && layout.photometric != PHOTOMETRIC_RGB) {
    throw WorkError(path, "has colours that are not RGB", "convert it to grey first");
  }
  if (is_colour && layout.type != StoredType::kU8) {
    throw WorkError(path, "has colours of more than 8 bits", "convert it to grey first");
  }
  return layout;
}

// The bytes of the open page, row by row, in this machine's byte order.
void read_page(TIFF& tiff, const std::string& path, const PageLayout& layout, char* rows) {
  if (!TIFFIsTiled(&tiff)) {
    if (static_cast<std::size_t>(TIFFScanlineSize64(&tiff)) != layout.row_bytes()) {
      throw damaged(path, "its rows are not as long as its header says");
    }
    for (std::uint32_t y = 0; y < layout.height; ++y) {
      if (TIFFReadScanline(&tiff, rows + y * layout.row_bytes(), y) != 1) {
        throw damaged(path, "row " + std::to_string(y) + " cannot be decoded");
      }
    }
    return;
  }
  std::uint32_t tile_width = 0, tile_height = 0;
  TIFFGetField(&tiff, TIFFTAG_TILEWIDTH, &tile_width);
  TIFFGetField(&tiff, TIFFTAG_TILELENGTH, &tile_height);
  const std::size_t pixel = layout.samples * bytes_of(layout.type);
  const auto tile_bytes = static_cast<double>(TIFFTileSize64(&tiff));
  if (tile_bytes != static_cast<double>(tile_width) * tile_height * static_cast<double>(pixel)) {
    throw damaged(path, "its tiles are not as large as its header says");
  }
  check_promise(path, tile_bytes, static_cast<double>(fs::file_size(path)), "deflate");
  std::vector<char> tile(static_cast<std::size_t>(tile_bytes));
  for (std::uint32_t y = 0; y < layout.height; y += tile_height) {
    for (std::uint32_t x = 0; x < layout.width; x += tile_width) {
      if (TIFFReadTile(&tiff, tile.data(), x, y, 0, 0) < 0) {
        throw damaged(path, "a tile cannot be decoded");
      }
      const std::size_t count = std::min(tile_width, layout.width - x) * pixel;
      for (std::uint32_t row = 0; row < std::min(tile_height, layout.height - y); ++row) {
        std::memcpy(rows + (y + row) * layout.row_bytes() + x * pixel,
                    tile.data() + std::size_t{row} * tile_width * pixel, count);
      }
    }
  }
}

// One value for each pixel: grey without its alpha, or Rec. 709 luma of 8-bit colours.
void keep_one_value(const PageLayout& layout, std::vector<char>& bytes) {
  const std::size_t width = bytes_of(layout.type);
  const std::size_t pixels = bytes.size() / (width * layout.samples);
  for (std::size_t n = 0; n < pixels && layout.samples > 1; ++n) {
    const char* at = bytes.data() + n * width * layout.samples;
    if (layout.samples == 2) {
      std::memmove(bytes.data() + n * width, at, width);
      continue;
    }
    bytes[n] = static_cast<char>(luma(reinterpret_cast<const unsigned char*>(at)));
  }
  bytes.resize(pixels * width);
}

// What all pages of a stack are like, and how many they are.
struct Survey {
  PageLayout layout;
  double pages = 0;
};

Survey survey_of(const std::vector<std::string>& files) {
  Survey survey;
  for (const std::string& file : files) {
    const TiffPointer tiff = open_tiff(file);
    do {
      const PageLayout page = page_layout(*tiff, file);
      if (survey.pages > 0 && !(page == survey.layout)) {
        throw WorkError(file, "has pages of different sizes or types", "make them alike first");
      }
      survey.layout = page;
      ++survey.pages;
      if (survey.pages > 1 << 20) throw damaged(file, "it has more than a million pages");
    } while (TIFFReadDirectory(tiff.get()));
  }
  return survey;
}

// Sends the values of all pages, one behind the other; one page is kept at a time.
void send_pages(const std::vector<std::string>& files, const PageLayout& layout,
                FenceOutput& output) {
  std::vector<char> page;
  for (const std::string& file : files) {
    const TiffPointer tiff = open_tiff(file);
    do {
      // The file may have changed on disk since its pages were counted.
      if (!(page_layout(*tiff, file) == layout))
        throw damaged(file, "it changed while it was read");
      page.resize(static_cast<std::size_t>(layout.bytes()));
      read_page(*tiff, file, layout, page.data());
      keep_one_value(layout, page);
      output.send(page.data(), page.size());
    } while (TIFFReadDirectory(tiff.get()));
  }
}

OpenedInput open_stack(const ReadRequest& request, const std::vector<std::string>& files) {
  OpenedInput opened;
  opened.result.format = "TIFF";
  opened.result.files = files;
  double file_bytes = 0;
  for (const std::string& file : files) file_bytes += static_cast<double>(fs::file_size(file));
  Survey survey;
  read_fenced(request.name, 2 * file_bytes, [&](FenceOutput& output) {
    const Survey found = survey_of(files);
    output.send(&found, sizeof found);
  })(reinterpret_cast<char*>(&survey), sizeof survey);
  const PageLayout layout = survey.layout;
  const double pages = survey.pages;
  check_promise(request.name, layout.bytes() * pages, file_bytes, "deflate");
  check_memory(layout.bytes(), request.name);
  opened.volume.dims = {static_cast<int>(layout.width), static_cast<int>(layout.height),
                        static_cast<int>(pages)};
  opened.stored_type = name_of(layout.type);
  opened.bytes_per_voxel_most = bytes_per_voxel_most(layout.type, {});
  const auto count = static_cast<std::size_t>(pages) * layout.width * layout.height;
  opened.read_voxels = [=](std::vector<std::string>& notes) {
    Progress progress(request.listener, "reading", count * bytes_of(layout.type));
    const auto from_the_first = [&]() -> ReadNext {
      const ReadNext next =
          read_fenced(request.name, 4 * layout.bytes() + 2 * file_bytes,
                      [&](FenceOutput& output) { send_pages(files, layout, output); });
      return [&progress, next](char* to, std::size_t bytes) {
        next(to, bytes);
        progress.advance(bytes);
      };
    };
    return voxels_read(request.name, layout.type, count, false, {}, from_the_first, notes);
  };
  std::vector<std::string>& notes = opened.result.notes;
  if (layout.samples > 1) {
    notes.push_back(layout.samples == 2 ? "its alpha channel is left out"
                                        : "its colours were made grey (Rec. 709 luma)");
  }
  if (layout.photometric == PHOTOMETRIC_PALETTE) {
    notes.push_back("a picture with a palette: its values are the numbers of the colours");
  }
  if (layout.photometric == PHOTOMETRIC_MINISWHITE) {
    notes.push_back("its greatest value means black; values are kept as stored");
  }
  if (!request.grid.spacing_mm) {
    notes.push_back(
        "TIFF does not tell distances in the patient: 1 mm along each axis, or "
        "give --spacing");
  }
  return opened;
}

bool recognises(const ReadRequest&, std::string_view first_bytes) {
  using namespace std::string_view_literals;
  for (const std::string_view magic : {"II*\0"sv, "MM\0*"sv, "II+\0"sv, "MM\0+"sv}) {
    if (first_bytes.starts_with(magic)) return true;
  }
  return false;
}

OpenedInput open(const ReadRequest& request) { return open_stack(request, {request.name}); }

}  // namespace

Format tiff_format() { return {recognises, open}; }

OpenedInput open_tiff_folder(const ReadRequest& request, std::vector<std::string> files) {
  std::ranges::sort(files, comes_before);
  OpenedInput opened = open_stack(request, files);
  opened.result.notes.push_back(std::to_string(files.size()) +
                                " files, in natural order of their names");
  return opened;
}

}  // namespace isolux
