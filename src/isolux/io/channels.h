#pragma once

#include <cstddef>

#include "isolux/io/stored_voxels.h"

namespace isolux {

/// Which of the numbers of a voxel is to be read, where several are stored one behind the other;
/// or, of 8-bit colours, that their luma is. Says in `result.notes` what was chosen; where they are
/// no colours, the request's volume chooses among them and among `volumes` volumes of such voxels.
struct ChannelChoice {
  Channels channels;
  std::uint64_t volume = 0;
};
ChannelChoice choose_channel(const ReadRequest& request, StoredType type, int count, bool is_colour,
                             std::uint64_t volumes, ReadResult& result);

/// Rec. 709 luma of red, green and blue, rounded.
unsigned char luma(const unsigned char* rgb);

/// Reads one number of `type` a voxel from where `channels.count` stand. Nothing larger than a
/// buffer is kept.
ReadNext one_a_voxel(const ReadNext& all, StoredType type, const Channels& channels);

}  // namespace isolux
