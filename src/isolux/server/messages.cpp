#include "isolux/server/messages.h"

#include <algorithm>
#include <cmath>
#include <initializer_list>
#include <string>

#include "isolux/base/error.h"

namespace isolux {
namespace {

using nlohmann::json;

constexpr int kDeepest = 16;
constexpr std::int64_t kLargestId = std::int64_t{1} << 53;  // a page's numbers are doubles

UsageError wrong(const std::string& why) {
  return {"message", why, "reload the page; it may be of another version"};
}

void check_keys(const json& message, std::initializer_list<const char*> keys) {
  if (message.size() != keys.size() + 1) throw wrong("has too many or too few keys");
  for (const char* key : keys) {
    if (!message.contains(key)) throw wrong(std::string("has no ") + key);
  }
}

std::int64_t whole(const json& value, std::int64_t high, const char* key) {
  if (!value.is_number_integer() || value < 0 || value > high) {
    throw wrong(std::string(key) + " is no whole number in its range");
  }
  return value.get<std::int64_t>();
}

std::int64_t id_of(const json& message) { return whole(message["id"], kLargestId, "id"); }

const json& pair_of(const json& message, const char* key) {
  const json& value = message[key];
  if (!value.is_array() || value.size() != 2 || !value[0].is_number() || !value[1].is_number()) {
    throw wrong(std::string(key) + " is no pair of numbers");
  }
  return value;
}

double share(const json& value) {
  const double number = value.get<double>();
  if (!(number >= 0 && number < 1)) throw wrong("at is outside the picture");
  return number;
}

std::vector<ShownLayer> layers_of(const json& list) {
  if (!list.is_array() || list.empty() || list.size() > 2) {
    throw wrong("show is no list of one or two layers");
  }
  std::vector<ShownLayer> layers;
  for (const json& name : list) {
    const auto layer =
        name.is_string() ? shown_layer_named(name.get_ref<const std::string&>()) : std::nullopt;
    if (!layer) throw wrong("show names a layer that is not there");
    layers.push_back(*layer);
  }
  return layers;
}

ClientMessage view_request(const json& message) {
  check_keys(message, {"id", "scene", "show", "light", "settled"});
  if (!message["settled"].is_boolean()) throw wrong("settled is neither true nor false");
  return ViewRequest{id_of(message), message["scene"], layers_of(message["show"]),
                     static_cast<std::size_t>(whole(message["light"], 1 << 20, "light")),
                     message["settled"].get<bool>()};
}

ClientMessage explain_request(const json& message) {
  check_keys(message, {"id", "scene", "pixel"});
  const json& pixel = pair_of(message, "pixel");
  return ExplainRequest{id_of(message), message["scene"],
                        static_cast<int>(whole(pixel[0], 1 << 20, "pixel")),
                        static_cast<int>(whole(pixel[1], 1 << 20, "pixel"))};
}

ClientMessage pick_request(const json& message) {
  check_keys(message, {"id", "at"});
  const json& at = pair_of(message, "at");
  return PickRequest{id_of(message), share(at[0]), share(at[1])};
}

ClientMessage describe_request(const json& message) {
  check_keys(message, {"id", "scene"});
  return DescribeRequest{id_of(message), message["scene"]};
}

ClientMessage acknowledgement(const json& message) {
  check_keys(message, {"id"});
  return Acknowledgement{id_of(message)};
}

ClientMessage stop_request(const json& message) {
  check_keys(message, {"id"});
  return StopRequest{id_of(message)};
}

}  // namespace

json parse_json(std::string_view text) {
  bool too_deep = false;
  const auto watch_depth = [&](int depth, json::parse_event_t, json&) {
    too_deep = too_deep || depth > kDeepest;
    return !too_deep;
  };
  json value = json::parse(text, watch_depth, /*allow_exceptions=*/false);
  if (value.is_discarded() || too_deep) throw wrong("is not valid JSON, or nested too deeply");
  return value;
}

ClientMessage parse_message(std::string_view text) {
  const json message = parse_json(text);
  if (!message.is_object() || !message.contains("type") || !message["type"].is_string()) {
    throw wrong("is no object with a type");
  }
  const auto& type = message["type"].get_ref<const std::string&>();
  if (type == "view") return view_request(message);
  if (type == "explain") return explain_request(message);
  if (type == "pick") return pick_request(message);
  if (type == "describe") return describe_request(message);
  if (type == "ack") return acknowledgement(message);
  if (type == "stop") return stop_request(message);
  throw wrong("is of no type that is known");
}

}  // namespace isolux
