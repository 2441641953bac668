#pragma once

#include <string_view>

namespace isolux {

/// One file of the page, as Vite made it from web/, inside the program.
struct PageFile {
  std::string_view path;  ///< "/", "/assets/index-1a2b3c.js", ...
  std::string_view content_type;
  std::string_view gzip;  ///< its bytes, compressed
};

/// The file of that path, or nullptr.
const PageFile* find_page_file(std::string_view path);

/// Whether there is a page at all: not where the program was built without Node.
bool has_page();

}  // namespace isolux
