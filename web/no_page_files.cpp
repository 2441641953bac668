// In place of the page's files where the program is built without Node.
#include "isolux/server/page_files.h"

namespace isolux {

const PageFile* find_page_file(std::string_view) { return nullptr; }

bool has_page() { return false; }

}  // namespace isolux
