#pragma once

#include <chrono>
#include <deque>
#include <functional>
#include <memory>
#include <mutex>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <string_view>

#include "isolux/server/drawing.h"
#include "isolux/server/messages.h"
#include "isolux/server/opened_inputs.h"
#include "isolux/server/work_queue.h"

namespace isolux {

/// The way back to one page. Called from any thread; does not wait.
class Outlet {
 public:
  virtual ~Outlet() = default;
  virtual void send_text(std::string text) = 0;
  virtual void send_bytes(std::string bytes) = 0;
};

/// One page's conversation. Its frames: the latest that was asked for, and the next only when the
/// page has said that the last one arrived, so that nothing piles up anywhere. What was held by a
/// shared pointer while at work is freed when that work ends.
class Client : public std::enable_shared_from_this<Client> {
 public:
  /// `inputs` and `queue` outlive it.
  Client(const OpenedInputs& inputs, WorkQueue& queue, const std::shared_ptr<Outlet>& outlet);

  /// A message from the page, of any content; never throws.
  void receive(std::string_view text);
  /// The page is gone: what waits for it is forgotten, what is being drawn for it stops.
  void leave();

 private:
  using Question = std::variant<ExplainRequest, PickRequest, DescribeRequest>;

  bool is_unwanted(const ViewRequest& request);
  bool has_work() const;
  void take_turn();
  void work();
  void draw(const ViewRequest& request);
  nlohmann::json answer(const ExplainRequest& request) const;
  nlohmann::json answer(const PickRequest& request);
  nlohmann::json answer(const DescribeRequest& request) const;
  void send(const nlohmann::json& message);
  void send_error(std::int64_t id, const std::string& message);

  const OpenedInputs& inputs_;
  WorkQueue& queue_;
  std::weak_ptr<Outlet> outlet_;  ///< which holds this client
  Drawing drawing_;               ///< belongs to whoever works on this client's turn

  std::mutex mutex_;  // for all below
  bool gone_ = false;
  bool has_turn_ = false;  ///< waits in the queue, or is being worked on
  std::deque<Question> questions_;
  std::optional<ViewRequest> wanted_;
  bool is_stopped_ = false;                     ///< what is being drawn, if it is a settled picture
  std::optional<std::int64_t> unacknowledged_;  ///< the frame that is on its way
  std::size_t bytes_sent_ = 0;
  std::chrono::steady_clock::time_point sent_at_;
  double bytes_per_ms_ = 0;  ///< of the line to the page; 0: not known
};

}  // namespace isolux
