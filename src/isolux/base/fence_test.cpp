#include "isolux/base/fence.h"

#include <gtest/gtest.h>
#include <unistd.h>

#include <cstdlib>
#include <fstream>
#include <vector>

#include "isolux/base/error.h"
#include "isolux/base/parallel.h"

namespace isolux {
namespace {

using Work = void (*)(FenceOutput&);

std::string received_from(Work work, const FenceLimits& limits = {}) {
  return Fence(limits, work).receive_text();
}

TEST(Fence, results_come_home_in_order) {
  Fence fence({}, [](FenceOutput& output) {
    output.send_text("one");
    output.send("twothree", 8);
    output.send_text(std::string(1 << 20, 'x'));
  });
  EXPECT_EQ(fence.receive_text(), "one");
  char piece[5] = {};
  fence.receive(piece, 3);
  EXPECT_EQ(std::string(piece), "two");
  fence.receive(piece, 5);
  EXPECT_EQ(std::string(piece, 5), "three");
  EXPECT_EQ(fence.receive_text(), std::string(1 << 20, 'x'));
}

TEST(Fence, a_crash_an_exception_and_silence_are_told_and_harm_nothing) {
  EXPECT_THROW(received_from([](FenceOutput&) { std::abort(); }), FenceBroken);
  EXPECT_THROW(received_from([](FenceOutput&) { throw 1; }), FenceBroken);
  EXPECT_THROW(received_from([](FenceOutput&) {}), FenceBroken);
}

TEST(Fence, an_error_that_the_work_tells_is_thrown_here_as_it_was) {
  try {
    received_from([](FenceOutput& output) {
      output.send_text("a start");
      throw WorkError("a.tif", "is damaged", "mend it");
    });
    Fence fence({}, [](FenceOutput&) { throw WorkError("a.tif", "is damaged", "mend it"); });
    fence.receive_text();
    FAIL();
  } catch (const WorkError& error) {
    EXPECT_EQ(std::string(error.what()), "a.tif: is damaged; mend it");
  }
}

TEST(Fence, the_child_has_room_for_files_whatever_is_open_here) {
  std::vector<int> files;
  for (int file = 0; (file = ::dup(0)) >= 0;) files.push_back(file);
  for (int n = 0; n < 2; ++n) {  // a pipe's two ends
    ::close(files.back());
    files.pop_back();
  }
  const std::string found = received_from([](FenceOutput& output) {
    output.send_text(std::ifstream("/dev/null") && std::ifstream("/dev/zero") ? "room" : "none");
  });
  for (const int file : files) ::close(file);
  EXPECT_EQ(found, "room");
}

TEST(Fence, endless_work_is_ended) {
  const auto endless = [](FenceOutput&) {
    while (true) ::sleep(1);
  };
  EXPECT_THROW(received_from(endless, {.seconds = 0.1}), FenceBroken);
}

TEST(Fence, hoarding_is_refused) {
  const auto hoard = [](FenceOutput& output) {
    std::vector<char> much(std::size_t{1} << 30, 'x');
    output.send_text("got " + std::to_string(much.size()));
  };
  EXPECT_THROW(received_from(hoard, {.memory = 64e6}), FenceBroken);
}

TEST(Fence, many_threads_may_each_have_one) {
  std::vector<std::string> texts(40);
  parallel_for(texts.size(), 1, [&](std::size_t begin, std::size_t) {
    Fence fence({}, [&](FenceOutput& output) { output.send_text(std::to_string(begin)); });
    texts[begin] = fence.receive_text();
  });
  for (std::size_t n = 0; n < texts.size(); ++n) EXPECT_EQ(texts[n], std::to_string(n));
}

}  // namespace
}  // namespace isolux
