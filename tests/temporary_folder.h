#pragma once

#include <gtest/gtest.h>

#include <filesystem>
#include <string>

namespace isolux {

/// A test with a folder of its own, which goes when it ends.
class TemporaryFolder : public testing::Test {
 protected:
  void SetUp() override {
    const testing::TestInfo& test = *testing::UnitTest::GetInstance()->current_test_info();
    folder_ = std::filesystem::temp_directory_path() /
              ("isolux-" + std::string(test.test_suite_name()) + "-" + test.name());
    std::filesystem::remove_all(folder_);
    std::filesystem::create_directory(folder_);
  }
  void TearDown() override { std::filesystem::remove_all(folder_); }

  std::filesystem::path folder_;
};

}  // namespace isolux
