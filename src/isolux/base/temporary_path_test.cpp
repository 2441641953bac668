#include "isolux/base/temporary_path.h"

#include <gtest/gtest.h>
#include <signal.h>
#include <unistd.h>

#include <fstream>

#include "isolux/base/output_file.h"
#include "temporary_folder.h"

namespace isolux {
namespace {

namespace fs = std::filesystem;

// Their names end in DeathTest, so that they run first, while there is one thread: they fork.
class TemporaryPathDeathTest : public TemporaryFolder {
 protected:
  std::string pattern() const { return (folder_ / "a-XXXXXX").string(); }
};

TEST_F(TemporaryPathDeathTest, files_and_folders_go_when_they_are_no_longer_used) {
  {
    const TemporaryPath file = TemporaryPath::new_file(pattern());
    const TemporaryPath folder = TemporaryPath::new_folder(pattern());
    ::close(file.descriptor());
    std::ofstream(fs::path(folder.path()) / "inside") << "text";
    EXPECT_TRUE(fs::is_regular_file(file.path()));
    EXPECT_TRUE(fs::is_directory(folder.path()));
  }
  EXPECT_TRUE(fs::is_empty(folder_));
}

TEST_F(TemporaryPathDeathTest, what_cannot_be_made_says_so) {
  const std::string nowhere = (folder_ / "missing" / "a-XXXXXX").string();
  EXPECT_EQ(TemporaryPath::new_file(nowhere).error(), ENOENT);
  EXPECT_EQ(TemporaryPath::new_folder(nowhere).error(), ENOENT);
}

TEST_F(TemporaryPathDeathTest, signals_that_end_the_program_leave_nothing_behind) {
  for (const int signal : {SIGINT, SIGTERM, SIGHUP}) {
    const auto end_in_use = [&] {
      const TemporaryPath file = TemporaryPath::new_file(pattern());
      const TemporaryPath folder = TemporaryPath::new_folder(pattern());
      for (int n = 0; n < 300; ++n) {  // more than one buffer of names
        std::ofstream(fs::path(folder.path()) / ("a file of number " + std::to_string(n))) << n;
      }
      TemporaryPath kept = TemporaryPath::new_file((folder_ / "kept-XXXXXX").string());
      kept.keep();
      ::raise(signal);
    };
    EXPECT_EXIT(end_in_use(), testing::KilledBySignal(signal), "");
  }
  int left = 0;
  for (const auto& entry : fs::directory_iterator(folder_)) {
    EXPECT_TRUE(entry.path().filename().string().starts_with("kept"));
    ++left;
  }
  EXPECT_EQ(left, 3);
}

TEST_F(TemporaryPathDeathTest, an_ignored_signal_stays_ignored) {
  const auto end_in_use = [&] {
    ::signal(SIGHUP, SIG_IGN);
    const TemporaryPath file = TemporaryPath::new_file(pattern());
    ::raise(SIGHUP);
    ::_exit(fs::exists(file.path()) ? 7 : 8);
  };
  EXPECT_EXIT(end_in_use(), testing::ExitedWithCode(7), "");
}

}  // namespace
}  // namespace isolux
