#pragma once

#include <cstdint>
#include <nlohmann/json.hpp>
#include <string_view>
#include <variant>
#include <vector>

#include "isolux/render/shown_layer.h"

// What a page may say over its WebSocket: one JSON object a message, of one of these kinds, with
// exactly these keys. docs/decisions/0012 has the whole conversation.

namespace isolux {

inline constexpr std::size_t kLongestMessage = 256 << 10;

/// { "type": "view", "id", "scene", "show": [one or two layers], "light", "settled" }
struct ViewRequest {
  std::int64_t id = 0;
  nlohmann::json scene;          ///< a scene document, not yet checked
  std::vector<ShownLayer> show;  ///< two: the halves of a split view
  std::size_t light = 0;         ///< whose cosines are shown
  bool settled = false;          ///< lossless and whole, in place of soon
};

/// { "type": "explain", "id", "scene", "pixel": [x, y] }
struct ExplainRequest {
  std::int64_t id = 0;
  nlohmann::json scene;
  int x = 0;
  int y = 0;
};

/// { "type": "pick", "id", "at": [across, down] }: what the last frame shows there, in shares of
/// its width and height.
struct PickRequest {
  std::int64_t id = 0;
  double across = 0;
  double down = 0;
};

/// { "type": "describe", "id", "scene" }: the scene with its defaults and as a command.
struct DescribeRequest {
  std::int64_t id = 0;
  nlohmann::json scene;
};

/// { "type": "ack", "id" }: that frame has arrived; the next may come.
struct Acknowledgement {
  std::int64_t id = 0;
};

/// { "type": "stop", "id" }: the settled picture that is being drawn is not wanted any more.
struct StopRequest {
  std::int64_t id = 0;
};

using ClientMessage = std::variant<ViewRequest, ExplainRequest, PickRequest, DescribeRequest,
                                   Acknowledgement, StopRequest>;

/// JSON of limited depth, so that no later step recurses too far.
/// @throws UsageError  where the text is no such JSON.
nlohmann::json parse_json(std::string_view text);

/// @throws UsageError  where the text is not exactly one of these messages.
ClientMessage parse_message(std::string_view text);

}  // namespace isolux
