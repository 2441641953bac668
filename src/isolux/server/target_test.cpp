#include "isolux/server/target.h"

#include <gtest/gtest.h>

namespace isolux {
namespace {

TEST(Target, a_name_is_decoded_and_what_is_no_escape_stays) {
  const Target target = parse_target("/open?name=CT%20%C3%A9%2Fa%zz%2");
  EXPECT_EQ(target.path, "/open");
  EXPECT_EQ(target.name, "CT \xc3\xa9/a%zz%2");
  EXPECT_EQ(parse_target("/open?other=1").name, "");
  EXPECT_EQ(parse_target("").path, "");
}

TEST(Target, a_file_name_cannot_leave_its_folder) {
  EXPECT_EQ(bare_file_name("../../etc/passwd"), "passwd");
  EXPECT_EQ(bare_file_name("C:\\scans\\head.nrrd"), "head.nrrd");
  for (const char* name : {"", "..", ".", "a/", "\n\t", "/"}) {
    EXPECT_EQ(bare_file_name(name), "file") << name;
  }
  EXPECT_EQ(bare_file_name(std::string("a\0b.nii", 7)), "ab.nii");
}

TEST(Target, a_long_name_keeps_its_end_and_whole_characters) {
  // 150 characters of two bytes each, and 4 bytes of suffix: the last 200 bytes are 98 characters
  // and the suffix.
  std::string name;
  for (int n = 0; n < 150; ++n) name += "\xc3\xa9";
  const std::string bare = bare_file_name(name + ".nii");
  EXPECT_EQ(bare.size(), 200u);
  EXPECT_TRUE(bare.starts_with("\xc3\xa9"));
  EXPECT_TRUE(bare.ends_with(".nii"));
  EXPECT_EQ(bare_file_name("x" + name + "nii").size(), 199u);
}

}  // namespace
}  // namespace isolux
