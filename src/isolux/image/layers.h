#pragma once

#include <string>
#include <vector>

namespace isolux {

/// Named float channels of one picture, row 0 at the top.
struct Layers {
  struct Channel {
    std::string name;  ///< "R", "diffuse.G", "position.X", ...
    std::vector<float> values;
  };

  int width = 0;
  int height = 0;
  std::vector<Channel> channels;

  /// The channel of that name, or nullptr.
  const Channel* find(const std::string& name) const {
    for (const Channel& channel : channels) {
      if (channel.name == name) return &channel;
    }
    return nullptr;
  }
};

}  // namespace isolux
