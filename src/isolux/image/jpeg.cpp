#include "isolux/image/jpeg.h"

#include <cstdio>
// jpeglib.h needs cstdio before it.
#include <jpeglib.h>

#include <csetjmp>

#include "isolux/base/error.h"
#include "isolux/base/memory.h"

namespace isolux {
namespace {

// libjpeg reports an error by calling a function, which must not return: it leaves by longjmp.
// Everything with a destructor is made before setjmp.
struct Reading {
  jpeg_decompress_struct jpeg{};
  jpeg_error_mgr errors{};
  std::jmp_buf back{};
  char message[JMSG_LENGTH_MAX] = {};

  Reading() {
    jpeg.err = jpeg_std_error(&errors);
    jpeg.client_data = this;
    errors.error_exit = [](j_common_ptr info) {
      auto* self = static_cast<Reading*>(info->client_data);
      info->err->format_message(info, self->message);
      std::longjmp(self->back, 1);
    };
    errors.emit_message = [](j_common_ptr, int) {};
  }
  ~Reading() { jpeg_destroy_decompress(&jpeg); }
  Reading(const Reading&) = delete;
  Reading& operator=(const Reading&) = delete;
};

}  // namespace

Picture decode_jpeg(std::string_view bytes, const std::string& name) {
  Picture picture;
  Reading reading;
  if (setjmp(reading.back)) {
    throw WorkError(name, std::string("damaged JPEG: ") + reading.message, "is the file complete?");
  }
  jpeg_decompress_struct& jpeg = reading.jpeg;
  jpeg_create_decompress(&jpeg);
  jpeg.client_data = &reading;  // which creating has cleared
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
