#include "isolux/image/png.h"

#include <png.h>

#include <csetjmp>
#include <cstring>

#include "isolux/base/error.h"
#include "isolux/base/memory.h"

namespace isolux {
namespace {

void append(png_structp png, png_bytep bytes, png_size_t count) {
  auto* out = static_cast<std::string*>(png_get_io_ptr(png));
  out->append(reinterpret_cast<const char*>(bytes), count);
}

void take(png_structp png, png_bytep bytes, png_size_t count) {
  auto* in = static_cast<std::string_view*>(png_get_io_ptr(png));
  if (in->size() < count) png_error(png, "the file ends too early");
  std::memcpy(bytes, in->data(), count);
  in->remove_prefix(count);
}

// libpng reports an error by calling this, which must not return: it leaves by longjmp.
[[noreturn]] void keep_message(png_structp png, png_const_charp message) {
  *static_cast<std::string*>(png_get_error_ptr(png)) = message;
  png_longjmp(png, 1);
}

void drop_message(png_structp, png_const_charp) {}

// What libpng allocates, given back however decode_png is left. No object with a destructor may be
// made between setjmp and longjmp, so everything is made before.
struct Reading {
  std::string message;
  png_structp png =
      png_create_read_struct(PNG_LIBPNG_VER_STRING, &message, keep_message, drop_message);
  png_infop info = png_create_info_struct(png);
  ~Reading() { png_destroy_read_struct(&png, &info, nullptr); }
};

struct Writing {
  std::string message;
  png_structp png =
      png_create_write_struct(PNG_LIBPNG_VER_STRING, &message, keep_message, drop_message);
  png_infop info = png_create_info_struct(png);
  ~Writing() { png_destroy_write_struct(&png, &info); }
};

}  // namespace

std::string encode_png(const Picture& picture, const Metadata& metadata, bool is_srgb,
                       PngEffort effort) {
  std::string bytes;
  std::vector<png_text> texts;
  for (const auto& [key, value] : metadata) {
    png_text text{};
    text.compression = PNG_ITXT_COMPRESSION_NONE;
    text.key = const_cast<char*>(key.c_str());
    text.text = const_cast<char*>(value.c_str());
    text.itxt_length = value.size();
    texts.push_back(text);
  }
  const auto stride = static_cast<std::size_t>(picture.width) * 3;
  Writing writing;
  if (setjmp(png_jmpbuf(writing.png))) {
    throw WorkError("PNG", "cannot encode: " + writing.message, "try a smaller picture");
  }
  png_set_write_fn(writing.png, &bytes, append, nullptr);
  png_set_user_limits(writing.png, 0x7fffffff, 0x7fffffff);
  png_set_IHDR(writing.png, writing.info, static_cast<png_uint_32>(picture.width),
               static_cast<png_uint_32>(picture.height), 8, PNG_COLOR_TYPE_RGB, PNG_INTERLACE_NONE,
               PNG_COMPRESSION_TYPE_DEFAULT, PNG_FILTER_TYPE_DEFAULT);
  if (is_srgb) png_set_sRGB(writing.png, writing.info, PNG_sRGB_INTENT_PERCEPTUAL);
  if (effort == PngEffort::kFast) {
    png_set_compression_level(writing.png, 1);
    png_set_filter(writing.png, PNG_FILTER_TYPE_BASE, PNG_FILTER_SUB);
  }
  png_set_text(writing.png, writing.info, texts.data(), static_cast<int>(texts.size()));
  png_write_info(writing.png, writing.info);
  for (int y = 0; y < picture.height; ++y) {
    png_write_row(writing.png, picture.rgb.data() + static_cast<std::size_t>(y) * stride);
  }
  png_write_end(writing.png, writing.info);
  return bytes;
}

DecodedPng decode_png(std::string_view bytes, const std::string& name) {
  DecodedPng decoded;
  Reading reading;
  if (setjmp(png_jmpbuf(reading.png))) {
    throw WorkError(name, "damaged PNG: " + reading.message, "is the file complete?");
  }
  png_set_read_fn(reading.png, &bytes, take);
  png_read_info(reading.png, reading.info);
  png_set_expand(reading.png);
  png_set_strip_16(reading.png);
  png_set_strip_alpha(reading.png);
  png_set_gray_to_rgb(reading.png);
  const int passes = png_set_interlace_handling(reading.png);
  png_read_update_info(reading.png, reading.info);
  decoded.picture.width = static_cast<int>(png_get_image_width(reading.png, reading.info));
  decoded.picture.height = static_cast<int>(png_get_image_height(reading.png, reading.info));
  const std::size_t stride = png_get_rowbytes(reading.png, reading.info);
  const double pixels = static_cast<double>(stride) * decoded.picture.height;
  constexpr double kMostDeflated = 1033;  // no more bytes than that come from one
  if (pixels > kMostDeflated * (1000 + static_cast<double>(bytes.size()))) {
    throw WorkError(name, "damaged PNG: it promises more pixels than its bytes can hold",
                    "is the file complete?");
  }
  check_memory(pixels, name);
  decoded.picture.rgb.resize(stride * static_cast<std::size_t>(decoded.picture.height));
  for (int row = 0; row < passes * decoded.picture.height; ++row) {
    const auto y = static_cast<std::size_t>(row % decoded.picture.height);
    png_read_row(reading.png, decoded.picture.rgb.data() + y * stride, nullptr);
  }
  png_read_end(reading.png, reading.info);
  png_textp texts = nullptr;
  const int count = png_get_text(reading.png, reading.info, &texts, nullptr);
  for (int n = 0; n < count; ++n) {
    const std::size_t length =
        texts[n].compression > 0 ? texts[n].itxt_length : texts[n].text_length;
    decoded.metadata[texts[n].key] = std::string(texts[n].text, length);
  }
  return decoded;
}

}  // namespace isolux
