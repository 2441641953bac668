#include "isolux/base/scratch_folder.h"

#include <cstdlib>
#include <system_error>

#include "isolux/base/error.h"

namespace isolux {

namespace fs = std::filesystem;

ScratchFolder::ScratchFolder(const std::string& purpose, const std::string& what) {
  std::error_code none;
  std::string name = (fs::temp_directory_path(none) / ("isolux-" + purpose + "-XXXXXX")).string();
  if (none || !::mkdtemp(name.data())) {
    throw WorkError(what, "there is no temporary folder for it",
                    "set TMPDIR to a folder with room");
  }
  path_ = name;
}

ScratchFolder::~ScratchFolder() {
  std::error_code ignored;
  fs::remove_all(path_, ignored);
}

}  // namespace isolux
