#include "isolux/base/output_file.h"

#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <sstream>

#include "isolux/base/error.h"
#include "temporary_folder.h"

namespace isolux {
namespace {

namespace fs = std::filesystem;

class OutputFile : public TemporaryFolder {
 protected:
  std::string contents(const fs::path& path) const {
    std::ifstream file(path, std::ios::binary);
    std::ostringstream text;
    text << file.rdbuf();
    return text.str();
  }
  std::size_t files_in_folder() const {
    return static_cast<std::size_t>(std::distance(fs::directory_iterator(folder_), {}));
  }
};

TEST_F(OutputFile, the_new_file_takes_the_place_of_the_old_and_leaves_nothing_beside_it) {
  const fs::path path = folder_ / "out.png";
  write_whole_file(path, "old");
  write_whole_file(path, "new");
  EXPECT_EQ(contents(path), "new");
  EXPECT_EQ(files_in_folder(), 1u);
}

TEST_F(OutputFile, a_symbolic_link_stays_a_link) {
  write_whole_file(folder_ / "real", "old");
  fs::create_symlink(folder_ / "real", folder_ / "link");
  write_whole_file(folder_ / "link", "new");
  EXPECT_TRUE(fs::is_symlink(folder_ / "link"));
  EXPECT_EQ(contents(folder_ / "real"), "new");
}

TEST_F(OutputFile, a_place_that_cannot_be_written_is_refused_before_the_work) {
  EXPECT_THROW(check_writable((folder_ / "missing" / "out.png").string()), WorkError);
  EXPECT_THROW(check_writable(folder_.string()), WorkError);
  EXPECT_THROW(check_writable(""), WorkError);
  EXPECT_NO_THROW(check_writable((folder_ / "out.png").string()));
}

TEST_F(OutputFile, a_full_device_is_an_error) {
  EXPECT_THROW(write_whole_file("/dev/full", "bytes"), WorkError);
}

}  // namespace
}  // namespace isolux
