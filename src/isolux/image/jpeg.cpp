#include "isolux/image/jpeg.h"

// jpeglib.h needs it first.
#include <cstdio>

#include <jpeglib.h>

#include <csetjmp>
#include <cstdlib>

#include "isolux/base/error.h"
#include "isolux/base/memory.h"

namespace isolux {
namespace {

// libjpeg reports an error by calling error_exit, which must not return: it leaves by longjmp.
struct Errors {
  jpeg_error_mgr manager;
  std::jmp_buf leave;
  char message[JMSG_LENGTH_MAX];
};

[[noreturn]] void keep_message(j_common_ptr jpeg) {
  auto* errors = reinterpret_cast<Errors*>(jpeg->err);
  (*jpeg->err->format_message)(jpeg, errors->message);
  std::longjmp(errors->leave, 1);
}

// What libjpeg allocates to decode, given back however decode_jpeg is left. No object with a
// destructor may be made between setjmp and longjmp, so everything is made before.
struct Reading {
  Errors errors;
  jpeg_decompress_struct jpeg{};

  Reading() {
    jpeg.err = jpeg_std_error(&errors.manager);
    errors.manager.error_exit = keep_message;
    errors.manager.emit_message = [](j_common_ptr, int) {};
  }
  ~Reading() { jpeg_destroy_decompress(&jpeg); }
  Reading(const Reading&) = delete;
  Reading& operator=(const Reading&) = delete;
};

}  // namespace

std::string encode_jpeg(const Picture& picture, int quality) {
  Errors errors;
  jpeg_compress_struct jpeg;
  jpeg.err = jpeg_std_error(&errors.manager);
  errors.manager.error_exit = keep_message;
  unsigned char* bytes = nullptr;
  unsigned long size = 0;
  if (setjmp(errors.leave)) {
    jpeg_destroy_compress(&jpeg);
    std::free(bytes);
    throw WorkError("JPEG", std::string("cannot encode: ") + errors.message,
                    "try a smaller picture");
  }
  jpeg_create_compress(&jpeg);
  jpeg_mem_dest(&jpeg, &bytes, &size);
  jpeg.image_width = static_cast<JDIMENSION>(picture.width);
  jpeg.image_height = static_cast<JDIMENSION>(picture.height);
  jpeg.input_components = 3;
  jpeg.in_color_space = JCS_RGB;
  jpeg_set_defaults(&jpeg);
  jpeg_set_quality(&jpeg, quality, TRUE);
  jpeg.dct_method = JDCT_IFAST;
  jpeg_start_compress(&jpeg, TRUE);
  const std::size_t stride = static_cast<std::size_t>(picture.width) * 3;
  while (jpeg.next_scanline < jpeg.image_height) {
    JSAMPROW row = const_cast<JSAMPROW>(picture.rgb.data() + jpeg.next_scanline * stride);
    jpeg_write_scanlines(&jpeg, &row, 1);
  }
  jpeg_finish_compress(&jpeg);
  jpeg_destroy_compress(&jpeg);
  std::string file(reinterpret_cast<const char*>(bytes), size);
  std::free(bytes);
  return file;
}

Picture decode_jpeg(std::string_view bytes, const std::string& name) {
  Picture picture;
  Reading reading;
  if (setjmp(reading.errors.leave)) {
    throw WorkError(name, std::string("damaged JPEG: ") + reading.errors.message,
                    "is the file complete?");
  }
  jpeg_decompress_struct& jpeg = reading.jpeg;
  jpeg_create_decompress(&jpeg);
  jpeg_mem_src(&jpeg, reinterpret_cast<const unsigned char*>(bytes.data()), bytes.size());
  jpeg_read_header(&jpeg, TRUE);
  jpeg.out_color_space = JCS_RGB;
  jpeg_start_decompress(&jpeg);
  picture.width = static_cast<int>(jpeg.output_width);
  picture.height = static_cast<int>(jpeg.output_height);
  const std::size_t stride = std::size_t{3} * jpeg.output_width;
  check_memory(static_cast<double>(stride) * jpeg.output_height, name);
  picture.rgb.resize(stride * jpeg.output_height);
  while (jpeg.output_scanline < jpeg.output_height) {
    JSAMPROW row = picture.rgb.data() + stride * jpeg.output_scanline;
    jpeg_read_scanlines(&jpeg, &row, 1);
  }
  jpeg_finish_decompress(&jpeg);
  return picture;
}

}  // namespace isolux
