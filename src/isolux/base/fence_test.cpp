#include "isolux/base/fence.h"

#include <gtest/gtest.h>
#include <unistd.h>

#include <cstdlib>
#include <vector>

#include "isolux/base/parallel.h"

namespace isolux {
namespace {

void receive_one(FenceInput& input) { input.receive_text(); }

TEST(Fence, results_come_home_in_order) {
  std::string first, second;
  run_fenced(
      {},
      [](FenceOutput& output) {
        output.send_text("one");
        output.send_text(std::string(1 << 20, 'x'));
      },
      [&](FenceInput& input) {
        first = input.receive_text();
        second = input.receive_text();
      });
  EXPECT_EQ(first, "one");
  EXPECT_EQ(second, std::string(1 << 20, 'x'));
}

TEST(Fence, a_crash_an_exception_and_silence_are_told_and_harm_nothing) {
  EXPECT_THROW(run_fenced(
                   {}, [](FenceOutput&) { std::abort(); }, receive_one),
               FenceBroken);
  EXPECT_THROW(run_fenced(
                   {}, [](FenceOutput&) { throw 1; }, receive_one),
               FenceBroken);
  EXPECT_THROW(run_fenced(
                   {}, [](FenceOutput&) {}, receive_one),
               FenceBroken);
}

TEST(Fence, endless_work_is_ended) {
  const auto endless = [](FenceOutput&) {
    while (true) ::sleep(1);
  };
  EXPECT_THROW(run_fenced({.seconds = 0.1}, endless, receive_one), FenceBroken);
}

TEST(Fence, hoarding_is_refused) {
  const auto hoard = [](FenceOutput& output) {
    std::vector<char> much(std::size_t{1} << 30, 'x');
    output.send_text("got " + std::to_string(much.size()));
  };
  EXPECT_THROW(run_fenced({.memory = 64e6}, hoard, receive_one), FenceBroken);
}

TEST(Fence, many_threads_may_each_have_one) {
  std::vector<std::string> texts(40);
  parallel_for(texts.size(), 1, [&](std::size_t begin, std::size_t) {
    run_fenced(
        {}, [&](FenceOutput& output) { output.send_text(std::to_string(begin)); },
        [&](FenceInput& input) { texts[begin] = input.receive_text(); });
  });
  for (std::size_t n = 0; n < texts.size(); ++n) EXPECT_EQ(texts[n], std::to_string(n));
}

}  // namespace
}  // namespace isolux
