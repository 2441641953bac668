#include "isolux/io/channels.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>
#include <memory>
#include <vector>

#include "isolux/base/error.h"
#include "isolux/io/chosen_volume.h"

namespace isolux {

ChannelChoice choose_channel(const ReadRequest& request, StoredType type, int count, bool is_colour,
                             std::uint64_t volumes, ReadResult& result) {
  ChannelChoice choice{{.count = count, .is_colour = false, .chosen = 0}, 0};
  choice.channels.is_colour = is_colour && type == StoredType::kU8 && (count == 3 || count == 4);
  const auto listed = choice.channels.is_colour ? 1u : static_cast<std::uint64_t>(count);
  if (volumes > std::numeric_limits<int>::max() / listed) {
    throw WorkError(request.name, "promises " + std::to_string(volumes) + " volumes",
                    "is its header damaged?");
  }
  if (choice.channels.is_colour) {
    result.notes.push_back("its colours were made grey (Rec. 709 luma)");
  } else if (count > 1) {
    result.notes.push_back("has " + std::to_string(count) + " values a voxel: each is a volume");
  }
  result.volume_count = static_cast<int>(volumes * listed);
  const std::uint64_t chosen = chosen_volume(request, result);
  choice.channels.chosen = static_cast<int>(chosen % listed);
  choice.volume = chosen / listed;
  return choice;
}

unsigned char luma(const unsigned char* rgb) {
  const double value = 0.2126 * rgb[0] + 0.7152 * rgb[1] + 0.0722 * rgb[2];
  return static_cast<unsigned char>(std::floor(value + 0.5));
}

ReadNext one_a_voxel(const ReadNext& all, StoredType type, const Channels& channels) {
  if (channels.count == 1) return all;
  const std::size_t width = bytes_of(type),
                    stride = width * static_cast<std::size_t>(channels.count);
  return [=, piece = std::vector<char>()](char* to, std::size_t bytes) mutable {
    constexpr std::size_t kVoxels = 1 << 14;
    for (std::size_t left = bytes / width; left > 0;) {
      const std::size_t count = std::min(left, kVoxels);
      piece.resize(count * stride);
      all(piece.data(), piece.size());
      for (std::size_t n = 0; n < count; ++n, to += width) {
        const char* voxel = piece.data() + n * stride;
        if (channels.is_colour) {
          *to = static_cast<char>(luma(reinterpret_cast<const unsigned char*>(voxel)));
        } else {
          std::memcpy(to, voxel + static_cast<std::size_t>(channels.chosen) * width, width);
        }
      }
      left -= count;
    }
  };
}

}  // namespace isolux
