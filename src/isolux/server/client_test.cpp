#include "isolux/server/client.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <atomic>
#include <condition_variable>
#include <functional>
#include <future>
#include <vector>

#include "isolux/volume/phantom.h"

namespace isolux {
namespace {

using nlohmann::json;

// A page that keeps what it is sent.
class Page final : public Outlet {
 public:
  void send_text(std::string text) override { keep(json::parse(text)); }
  void send_bytes(std::string bytes) override {
    std::size_t length = 0;
    for (int n = 3; n >= 0; --n) {
      length = length << 8 | static_cast<unsigned char>(bytes[static_cast<std::size_t>(n)]);
    }
    json header = json::parse(bytes.substr(4, length));
    header["type"] = "frame";
    EXPECT_EQ(bytes.size(), 4 + length + header["lengths"][0].get<std::size_t>());
    keep(std::move(header));
  }
  // The first `count` messages, once they are there.
  std::vector<json> wait_for(std::size_t count) {
    std::unique_lock lock(mutex_);
    arrived_.wait_for(lock, std::chrono::seconds(20), [&] { return messages_.size() >= count; });
    return messages_;
  }
  json message(std::size_t n) {
    const std::lock_guard lock(mutex_);
    return messages_.at(n);
  }
  std::size_t count() {
    const std::lock_guard lock(mutex_);
    return messages_.size();
  }

 private:
  void keep(json message) {
    const std::lock_guard lock(mutex_);
    messages_.push_back(std::move(message));
    arrived_.notify_all();
  }

  std::mutex mutex_;
  std::condition_variable arrived_;
  std::vector<json> messages_;
};

class ClientTest : public testing::Test {
 protected:
  ClientTest() {
    ReadResult sphere;
    sphere.volume = std::make_shared<Volume>(sphere_phantom(17));
    sphere.name = "phantom:sphere";
    inputs_.add(sphere, json::object(), false);
  }
  ~ClientTest() override { queue_.finish(); }

  static json scene(int size = 16) {
    return {{"isolux_scene", 1},
            {"input", {"phantom:sphere"}},
            {"size", {size, size}},
            {"surface", {{{"iso", 0.5}}}}};
  }
  void ask_for_view(int id, const json& document, bool settled = true) {
    client_->receive(json{
        {"type", "view"},
        {"id", id},
        {"scene", document},
        {"show", {"picture"}},
        {"light", 0},
        {"settled",
         settled}}.dump());
  }
  void acknowledge(int id) { client_->receive(json{{"type", "ack"}, {"id", id}}.dump()); }

  OpenedInputs inputs_;
  WorkQueue queue_{1};
  std::shared_ptr<Page> page_ = std::make_shared<Page>();
  std::shared_ptr<Client> client_ = std::make_shared<Client>(inputs_, queue_, page_);
};

TEST_F(ClientTest, a_page_that_does_not_acknowledge_gets_one_frame_and_then_the_latest) {
  ask_for_view(1, scene());
  page_->wait_for(1);
  for (int id = 2; id <= 50; ++id) ask_for_view(id, scene());
  // Questions are answered meanwhile; when this one is, any frame before it would be there too.
  client_->receive(R"({"type":"pick","id":90,"at":[0.5,0.5]})");
  EXPECT_EQ(page_->wait_for(2)[1]["type"], "picked");
  acknowledge(1);
  EXPECT_EQ(page_->wait_for(3)[2]["id"], 50);
  acknowledge(50);
  client_->receive(R"({"type":"pick","id":91,"at":[0.5,0.5]})");
  EXPECT_EQ(page_->wait_for(4)[3]["id"], 91);
}

TEST_F(ClientTest, a_moved_lamp_does_not_trace_eye_rays_again) {
  json document = scene();
  for (int id = 1; id <= 5; ++id) {
    document["light"] = {{{"kind", "point"}, {"at", {id, -60, 57}}}};
    ask_for_view(id, document, id % 2 == 0);
    const json frame = page_->wait_for(static_cast<std::size_t>(id)).back();
    EXPECT_EQ(frame["counters"]["visibility"], 1);
    EXPECT_EQ(frame["counters"]["lighting"], id);
    acknowledge(id);
  }
}

TEST_F(ClientTest, a_scene_that_cannot_be_drawn_is_an_error_that_says_why) {
  json document = scene();
  document["input"] = {"/etc/passwd"};
  ask_for_view(1, document);
  EXPECT_EQ(page_->wait_for(1)[0]["message"],
            "/etc/passwd: is not open here; drop the file on the page to open it");
  document = scene();
  document["spacing"] = {2, 2, 2};
  ask_for_view(2, document);
  EXPECT_EQ(page_->wait_for(2)[1]["id"], 2);
  document = scene(30000);
  ask_for_view(3, document);
  EXPECT_EQ(page_->wait_for(3)[2]["type"], "error");
  client_->receive("nonsense");
  EXPECT_EQ(page_->wait_for(4)[3]["type"], "error");
  ask_for_view(5, scene());
  EXPECT_EQ(page_->wait_for(5)[4]["type"], "frame");
}

TEST_F(ClientTest, a_flood_of_questions_is_bounded) {
  // The only thread is held up while they come.
  std::mutex gate;
  gate.lock();
  queue_.add([&] { const std::lock_guard wait(gate); });
  for (int id = 1; id <= 1000; ++id) {
    client_->receive(R"({"type":"pick","id":)" + std::to_string(id) + R"(,"at":[0.5,0.5]})");
  }
  gate.unlock();
  EXPECT_EQ(page_->wait_for(8).back()["id"], 1000);
  EXPECT_EQ(page_->count(), 8u);
}

// Messages of all pages are delivered by a piece of work that takes its turns like any other, so
// what happens does not hang on time.
TEST_F(ClientTest, of_eight_pages_each_has_its_turn_whatever_one_of_them_asks_for) {
  constexpr int kRounds = 20;
  struct Visit {
    std::shared_ptr<Page> page;
    std::shared_ptr<Client> client;
    std::size_t read = 0;
  };
  std::vector<Visit> visits;
  for (int n = 0; n < 8; ++n) {
    const auto page = std::make_shared<Page>();
    visits.push_back({page, std::make_shared<Client>(inputs_, queue_, page)});
  }
  int id = 0, round = 0;
  const auto speak = [&](Visit& visit, bool is_greedy) {
    client_ = visit.client;
    for (; visit.read < visit.page->count(); ++visit.read) {
      const json said = visit.page->message(visit.read);
      if (said["type"] == "frame") acknowledge(said["id"]);
    }
    ask_for_view(++id, scene(is_greedy ? 96 : 16), false);
    for (int n = 0; is_greedy && n < 4; ++n) {
      ask_for_view(++id, scene(96), false);
      client_->receive(
          json{{"type", "explain"}, {"id", ++id}, {"scene", scene(96)}, {"pixel", {8, 8}}}.dump());
    }
  };
  std::promise<std::vector<std::size_t>> over;
  std::function<void()> deliver = [&] {
    if (round++ == kRounds) {
      std::vector<std::size_t> answers;
      for (Visit& visit : visits) answers.push_back(visit.page->count());
      return over.set_value(answers);
    }
    for (Visit& visit : visits) speak(visit, &visit == &visits[0]);
    queue_.add(deliver);
  };
  queue_.add(deliver);
  EXPECT_EQ(over.get_future().get(), std::vector<std::size_t>(visits.size(), kRounds));
  queue_.finish();
}

TEST_F(ClientTest, a_picture_that_takes_long_holds_up_no_other_page) {
  // Seconds of paths, on the only place for a picture; nobody waits for them at the end.
  WorkQueue queue(1, 1);
  const auto slow_page = std::make_shared<Page>(), quick_page = std::make_shared<Page>();
  const auto slow = std::make_shared<Client>(inputs_, queue, slow_page);
  const auto quick = std::make_shared<Client>(inputs_, queue, quick_page);
  json paths = scene(160);
  paths["indirect"] = "path";
  paths["spp"] = 4000;
  client_ = slow;
  ask_for_view(1, paths);
  client_ = quick;
  ask_for_view(2, scene());
  EXPECT_EQ(quick_page->wait_for(1)[0]["type"], "frame");
  for (std::size_t n = 0; n < slow_page->count(); ++n) {
    EXPECT_EQ(slow_page->message(n)["type"], "progress");
  }
  slow->leave();
  queue.finish();
}

TEST_F(ClientTest, a_question_is_answered_with_what_the_program_says_elsewhere) {
  client_->receive(
      json{{"type", "explain"}, {"id", 1}, {"scene", scene()}, {"pixel", {8, 8}}}.dump());
  const json why = page_->wait_for(1)[0];
  EXPECT_EQ(why["type"], "explanation");
  EXPECT_TRUE(why["hit"]);
  client_->receive(json{{"type", "describe"}, {"id", 2}, {"scene", scene()}}.dump());
  EXPECT_EQ(page_->wait_for(2)[1]["command"],
            "isolux render phantom:sphere --size 16x16 --surface iso=0.5");
}

TEST_F(ClientTest, who_has_left_is_sent_nothing_more) {
  std::mutex gate;
  gate.lock();
  queue_.add([&] { const std::lock_guard wait(gate); });
  ask_for_view(1, scene());
  client_->receive(R"({"type":"pick","id":2,"at":[0.5,0.5]})");
  client_->leave();
  gate.unlock();
  queue_.finish();
  EXPECT_EQ(page_->count(), 0u);
}

TEST(WorkQueue, beside_a_piece_that_has_stepped_aside_one_other_is_done_at_a_time) {
  WorkQueue queue(1, 2);
  std::promise<void> end, all_done;
  queue.add([&] {
    WorkQueue::Place place(queue);
    place.step_aside();
    place.step_aside();
    end.get_future().wait();
  });
  constexpr int kPieces = 100;
  std::atomic<int> under_way = 0, most = 0, done = 0;
  for (int n = 0; n < kPieces; ++n) {
    queue.add([&] {
      most = std::max<int>(most, ++under_way);
      std::this_thread::yield();
      --under_way;
      if (++done == kPieces) all_done.set_value();
    });
  }
  EXPECT_EQ(all_done.get_future().wait_for(std::chrono::seconds(60)), std::future_status::ready);
  EXPECT_EQ(most, 1);
  end.set_value();
  queue.finish();
}

TEST(WorkQueue, who_adds_the_next_piece_when_the_last_is_done_takes_turns) {
  WorkQueue queue(1);
  std::vector<char> order;
  std::mutex gate;
  gate.lock();
  queue.add([&] { const std::lock_guard wait(gate); });
  std::function<void(char, int)> add = [&](char name, int pieces) {
    queue.add([&, name, pieces] {
      order.push_back(name);
      if (pieces > 1) add(name, pieces - 1);
    });
  };
  add('a', 3);
  add('b', 3);
  gate.unlock();
  while (queue.waiting() > 0 || order.size() < 6) std::this_thread::yield();
  queue.finish();
  EXPECT_EQ(std::string(order.begin(), order.end()), "ababab");
}

}  // namespace
}  // namespace isolux
