#include "isolux/server/access.h"

#include <gtest/gtest.h>
#include <sys/stat.h>

#include <cstdlib>
#include <filesystem>

#include "temporary_folder.h"

namespace isolux {
namespace {

namespace fs = std::filesystem;

TEST(Access, on_loopback_only_loopback_names_are_ours) {
  const Access access("t", "127.0.0.1");
  for (const char* host :
       {"127.0.0.1:7411", "127.9.9.9", "localhost:80", "LocalHost", "[::1]:7411"})
    EXPECT_TRUE(access.host_is_ours(host)) << host;
  for (const char* host : {"evil.example", "localhost.evil.example", "127.0.0.1.evil.example",
                           "192.168.0.7", "", ":7411", "[::1", "127.evil"})
    EXPECT_FALSE(access.host_is_ours(host)) << host;
}

TEST(Access, beyond_loopback_addresses_are_ours_and_names_are_not) {
  // A name can be made to point here by whoever owns it; an address cannot.
  const Access access("t", "0.0.0.0");
  EXPECT_TRUE(access.host_is_ours("192.168.0.7:7411"));
  EXPECT_TRUE(access.host_is_ours("[fe80::1]:7411"));
  EXPECT_FALSE(access.host_is_ours("evil.example:7411"));
  EXPECT_FALSE(access.host_is_ours("bad.cafe:7411"));
}

TEST(Access, an_origin_is_ours_where_it_names_the_same_host_and_port) {
  const Access access("t", "127.0.0.1");
  EXPECT_TRUE(access.origin_is_ours("http://localhost:9", "localhost:9"));
  for (const char* origin : {"", "null", "http://localhost", "https://localhost:9",
                             "http://localhost:99", "http://evil.example"})
    EXPECT_FALSE(access.origin_is_ours(origin, "localhost:9")) << origin;
}

TEST(Access, only_the_whole_token_is_right) {
  const Access access("abcdef", "127.0.0.1");
  EXPECT_TRUE(access.token_is_right("abcdef"));
  for (const char* given : {"", "abcde", "abcdeg", "Abcdef", "abcdefa"})
    EXPECT_FALSE(access.token_is_right(given)) << given;
}

class UserToken : public TemporaryFolder {};

TEST_F(UserToken, is_kept_in_a_file_that_is_ours_alone) {
  ::setenv("XDG_STATE_HOME", folder_.c_str(), 1);
  const std::string token = user_token();
  EXPECT_EQ(token.size(), 64u);
  EXPECT_EQ(user_token(), token);
  const fs::path file = folder_ / "isolux" / "view-token";
  EXPECT_EQ(fs::status(file).permissions(), fs::perms::owner_read | fs::perms::owner_write);
  // What others could have read or written is not a secret any more.
  fs::permissions(file, fs::perms::owner_all | fs::perms::group_read);
  const std::string fresh = user_token();
  EXPECT_NE(fresh, token);
  EXPECT_EQ(user_token(), fresh);
  ::unsetenv("XDG_STATE_HOME");
}

}  // namespace
}  // namespace isolux
