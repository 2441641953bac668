#include "isolux/server/client.h"

#include <algorithm>
#include <exception>
#include <utility>

#include "isolux/base/error.h"
#include "isolux/render/explanation_json.h"
#include "isolux/scene/document.h"
#include "isolux/server/starting_scene.h"

namespace isolux {
namespace {

using nlohmann::json;

constexpr std::size_t kMostQuestions = 8;  // each may hold megabytes
constexpr double kMostPixels = 1 << 24;
// A picture that takes longer than this tells how far it is, this often, and holds up nobody.
constexpr auto kNoticeable = std::chrono::milliseconds(250);

// Thrown out of a picture that nobody waits for any more.
struct Superseded {};

json numbers(Vec3 v) { return {v.x, v.y, v.z}; }
json numbers(Rgb c) { return {c.r, c.g, c.b}; }

json material_json(const Material& material) {
  return {{"ka", numbers(material.ka)},
          {"kd", numbers(material.kd)},
          {"ks", numbers(material.ks)},
          {"shininess", material.shininess}};
}

SceneDescription describe_for_page(const json& document) {
  if (!document.is_object() || !document.contains("input")) {
    throw UsageError("scene", "names no input", "write \"input\": [...]");
  }
  SceneDescription description = describe(document, "scene");
  if (static_cast<double>(description.width) * description.height > kMostPixels) {
    throw UsageError("scene size", "is too large to be shown", "save the picture instead");
  }
  return description;
}

std::string message_of(const std::exception_ptr& failure) {
  try {
    std::rethrow_exception(failure);
  } catch (const std::bad_alloc&) {
    return "memory: there is not enough; try a smaller window or volume";
  } catch (const std::exception& error) {
    return error.what();
  }
}

}  // namespace

Client::Client(const OpenedInputs& inputs, WorkQueue& queue, const std::shared_ptr<Outlet>& outlet)
    : inputs_(inputs), queue_(queue), outlet_(outlet) {}

void Client::receive(std::string_view text) {
  ClientMessage message;
  try {
    message = parse_message(text);
  } catch (...) {
    send_error(0, message_of(std::current_exception()));
    return;
  }
  const std::lock_guard lock(mutex_);
  if (const auto* ack = std::get_if<Acknowledgement>(&message)) {
    if (unacknowledged_ != ack->id) return;
    unacknowledged_.reset();
    const double ms =
        std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - sent_at_)
            .count();
    const double rate = static_cast<double>(bytes_sent_) / std::max(ms, 0.1);
    bytes_per_ms_ = bytes_per_ms_ == 0 ? rate : 0.7 * bytes_per_ms_ + 0.3 * rate;
  } else if (auto* view = std::get_if<ViewRequest>(&message)) {
    wanted_ = std::move(*view);
  } else if (std::holds_alternative<StopRequest>(message)) {
    is_stopped_ = true;
    if (wanted_ && wanted_->settled) wanted_.reset();
  } else {
    if (questions_.size() == kMostQuestions) questions_.pop_front();  // the page has moved on
    std::visit(
        [&]<typename T>(T& request) {
          if constexpr (std::is_constructible_v<Question, T>) questions_.push_back(request);
        },
        message);
  }
  take_turn();
}

void Client::leave() {
  const std::lock_guard lock(mutex_);
  gone_ = true;
  wanted_.reset();
  questions_.clear();
}

bool Client::has_work() const {
  return !gone_ && (!questions_.empty() || (wanted_ && !unacknowledged_));
}

void Client::take_turn() {
  if (has_turn_ || !has_work()) return;
  has_turn_ = true;
  queue_.add([self = shared_from_this()] { self->work(); });
}

void Client::work() {
  std::optional<Question> question;
  std::optional<ViewRequest> view;
  {
    const std::lock_guard lock(mutex_);
    if (!gone_ && !questions_.empty()) {
      question = std::move(questions_.front());
      questions_.pop_front();
    } else if (has_work()) {
      view = std::exchange(wanted_, std::nullopt);
      is_stopped_ = false;
    }
  }
  if (question) {
    std::visit(
        [&](const auto& request) {
          try {
            send(answer(request));
          } catch (...) {
            send_error(request.id, message_of(std::current_exception()));
          }
        },
        *question);
  } else if (view) {
    draw(*view);
  }
  const std::lock_guard lock(mutex_);
  has_turn_ = false;
  take_turn();
}

// A moving frame is finished whatever comes, or a long drag would show nothing; a settled one makes
// way for what moves next.
bool Client::is_unwanted(const ViewRequest& request) {
  const std::lock_guard lock(mutex_);
  return gone_ || (request.settled && (wanted_ || is_stopped_));
}

void Client::draw(const ViewRequest& request) {
  WorkQueue::Place place(queue_);
  auto told_at = std::chrono::steady_clock::now();
  const auto tell_or_give_way = [&](const std::string& label, double share) {
    if (is_unwanted(request)) throw Superseded();
    const auto now = std::chrono::steady_clock::now();
    if (now - told_at < kNoticeable) return;
    told_at = now;
    place.step_aside();
    if (!request.settled) return;
    send({{"type", "progress"}, {"id", request.id}, {"label", label}, {"share", share}});
  };
  double bytes_per_ms = 0;
  {
    const std::lock_guard lock(mutex_);
    bytes_per_ms = bytes_per_ms_;
  }
  try {
    const SceneDescription description = describe_for_page(request.scene);
    std::string frame = drawing_.frame(request, description, inputs_.inputs_of(request.scene),
                                       bytes_per_ms, tell_or_give_way);
    const std::lock_guard lock(mutex_);
    unacknowledged_ = request.id;
    bytes_sent_ = frame.size();
    sent_at_ = std::chrono::steady_clock::now();
    if (const auto outlet = outlet_.lock()) outlet->send_bytes(std::move(frame));
  } catch (const Superseded&) {
  } catch (...) {
    send_error(request.id, message_of(std::current_exception()));
  }
}

json Client::answer(const ExplainRequest& request) const {
  const SceneDescription description = describe_for_page(request.scene);
  if (request.x >= description.width || request.y >= description.height) {
    throw UsageError("pixel", "lies outside the picture", "click inside it");
  }
  const Scene scene = resolve(description, inputs_.inputs_of(request.scene));
  const Explanation why = explain(scene, request.x, request.y);
  json reply = explain_json(why);
  reply["type"] = "explanation";
  reply["id"] = request.id;
  reply["ambient_light"] = numbers(scene.ambient);
  if (why.is_hit()) reply["material"] = material_json(why.layers[0].material);
  return reply;
}

json Client::answer(const PickRequest& request) {
  const auto picked = drawing_.pick(request.across, request.down);
  json reply = {{"type", "picked"}, {"id", request.id}, {"hit", picked.has_value()}};
  if (picked) {
    reply["position"] = numbers(picked->position);
    reply["normal"] = numbers(picked->normal);
    reply["depth"] = picked->depth_mm;
  }
  return reply;
}

json Client::answer(const DescribeRequest& request) const {
  describe_for_page(request.scene);
  const json scene = with_all_surfaces(request.scene, inputs_.inputs_of(request.scene));
  return {{"type", "described"},
          {"id", request.id},
          {"scene", with_defaults(scene)},
          {"command", command_of(without_defaults(scene))}};
}

void Client::send(const json& message) {
  const auto outlet = outlet_.lock();
  if (outlet) outlet->send_text(message.dump(-1, ' ', false, json::error_handler_t::replace));
}

void Client::send_error(std::int64_t id, const std::string& message) {
  send({{"type", "error"}, {"id", id}, {"message", message}});
}

}  // namespace isolux
