#include "isolux/base/parallel.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <chrono>
#include <stdexcept>
#include <thread>
#include <vector>

#include "isolux/base/progress.h"

namespace isolux {
namespace {

TEST(Parallel, every_item_is_visited_once_for_any_number_of_threads) {
  for (const int threads : {0, 1, 2, 7}) {
    std::vector<int> visits(1000, 0);
    with_threads(threads, [&] {
      parallel_for(visits.size(), 7, [&](std::size_t begin, std::size_t end) {
        EXPECT_LE(end - begin, 7u);
        for (std::size_t n = begin; n < end; ++n) ++visits[n];
      });
    });
    EXPECT_EQ(visits, std::vector<int>(1000, 1));
  }
}

TEST(Parallel, an_exception_inside_comes_out) {
  EXPECT_THROW(
      parallel_for(100, 1, [](std::size_t, std::size_t) { throw std::runtime_error("x"); }),
      std::runtime_error);
}

TEST(Progress, is_told_in_order_up_to_the_end) {
  std::vector<double> shares;
  const ProgressListener listener = [&](const std::string&, double share) {
    shares.push_back(share);
  };
  Progress progress(listener, "tracing", 1000);
  parallel_for(1000, 3, [&](std::size_t begin, std::size_t end) { progress.advance(end - begin); });
  EXPECT_TRUE(std::is_sorted(shares.begin(), shares.end()));
  EXPECT_EQ(shares.front(), 0);
  EXPECT_EQ(shares.back(), 1);
  const auto repeated = std::ranges::unique(shares);
  EXPECT_LE(shares.size() - repeated.size(), 101u);
}

TEST(Progress, a_listener_is_told_again_after_a_while_though_no_percent_more_is_done) {
  int told = 0;
  const ProgressListener listener = [&](const std::string&, double) { ++told; };
  Progress progress(listener, "tracing", 1000000);
  progress.advance(1);
  const int before = told;
  std::this_thread::sleep_for(std::chrono::milliseconds(150));
  progress.advance(1);
  EXPECT_GT(told, before);
}

}  // namespace
}  // namespace isolux
