#include "isolux/base/mapped_file.h"

#include <gtest/gtest.h>
#include <unistd.h>

#include <fstream>

#include "isolux/base/error.h"
#include "temporary_folder.h"

namespace isolux {
namespace {

class MappedFileTest : public TemporaryFolder {
 protected:
  std::string file_of(const std::string& bytes, const std::string& name = "file") const {
    const std::string path = (folder_ / name).string();
    std::ofstream(path, std::ios::binary) << bytes;
    return path;
  }
};

TEST_F(MappedFileTest, its_bytes_are_those_of_the_file) {
  const MappedFile file(file_of("some bytes"));
  EXPECT_EQ(std::string(file.data(), file.size()), "some bytes");
}

TEST_F(MappedFileTest, what_cannot_be_mapped_is_refused) {
  EXPECT_THROW(MappedFile((folder_ / "missing").string()), WorkError);
  EXPECT_THROW(MappedFile(folder_.string()), WorkError);
  EXPECT_THROW(MappedFile(file_of("")), WorkError);
}

// Names that end in DeathTest run first, while there is one thread: these tests fork.
using MappedFileDeathTest = MappedFileTest;

TEST_F(MappedFileDeathTest, a_file_cut_short_in_use_ends_the_program_with_one_line) {
  const std::string path = file_of(std::string(1 << 20, 'x'));
  const auto touch_what_is_gone = [&] {
    const MappedFile other(file_of("x", "other"));  // mapped as well, and whole
    const MappedFile file(path);
    std::filesystem::resize_file(path, 5000);
    volatile char last = file.data()[file.size() - 1];
    static_cast<void>(last);
  };
  EXPECT_EXIT(touch_what_is_gone(), testing::ExitedWithCode(1),
              "^isolux: error: " + path + ": was cut short.*; leave a file alone.*\n$");
}

TEST_F(MappedFileDeathTest, another_bus_error_is_still_a_crash) {
  const auto raise_in_another_place = [&] {
    { const MappedFile gone(file_of("x")); }
    ::raise(SIGBUS);
    ::raise(SIGBUS);
  };
  EXPECT_DEATH(raise_in_another_place(), "");
}

}  // namespace
}  // namespace isolux
