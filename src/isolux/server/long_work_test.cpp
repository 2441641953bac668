#include "isolux/server/long_work.h"

#include <gtest/gtest.h>

#include <condition_variable>

#include "isolux/base/error.h"

namespace isolux {
namespace {

// Something that a test waits for.
class Signal {
 public:
  void give() {
    const std::lock_guard lock(mutex_);
    is_given_ = true;
    changed_.notify_all();
  }
  bool wait() {
    std::unique_lock lock(mutex_);
    return changed_.wait_for(lock, std::chrono::seconds(20), [&] { return is_given_; });
  }

 private:
  std::mutex mutex_;
  std::condition_variable changed_;
  bool is_given_ = false;
};

TEST(LongWork, tells_how_far_a_piece_is_until_it_is_done) {
  Signal told, looked, done;
  LongWork works;
  works.add("a", [&](Errand& errand) {
    errand.listener()("reading", 0.25);
    told.give();
    looked.wait();
  });
  works.add("b", [&](Errand&) { done.give(); });
  ASSERT_TRUE(told.wait());
  EXPECT_EQ(works.report("a"), (nlohmann::json{{"label", "reading"}, {"share", 0.25}}));
  EXPECT_EQ(works.report("b")->at("label"), "waiting");
  looked.give();
  ASSERT_TRUE(done.wait());
  EXPECT_FALSE(works.report("a"));
}

TEST(LongWork, ends_where_nobody_waits_any_more) {
  Signal begun, cancelled, ended;
  LongWork works;
  const auto errand = works.add("a", [&](Errand& own) {
    const ProgressListener listener = own.listener();
    listener("reading", 0);
    begun.give();
    cancelled.wait();
    try {
      listener("reading", 0.5);
    } catch (const WorkError&) {
      ended.give();
    }
  });
  ASSERT_TRUE(begun.wait());
  errand->cancel();
  cancelled.give();
  EXPECT_TRUE(ended.wait());
}

TEST(LongWork, takes_eight_pieces_and_no_more) {
  Signal gate;
  LongWork works;
  for (int n = 0; n < 8; ++n) EXPECT_TRUE(works.add("a", [&](Errand&) { gate.wait(); }));
  EXPECT_FALSE(works.add("a", [](Errand&) {}));
  gate.give();
  works.finish();
}

}  // namespace
}  // namespace isolux
