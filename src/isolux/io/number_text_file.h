#pragma once

#include <string>
#include <vector>

#include "isolux/io/stored_voxels.h"

namespace isolux {

/// Numbers that are written as text, in stretches one behind the other (a stretch may promise more
/// bytes than there are), with blanks or commas between
/// them. Nothing larger than a buffer is kept.
/// @throws WorkError  (when read) where one is missing, or is no number of the type.
ReadNext read_number_text(std::vector<Stretch> stretches, StoredType type);

/// Bytes that are written as pairs of hexadecimal digits; blanks and line ends do not count.
/// @throws as read_number_text.
ReadNext read_hex_text(std::vector<Stretch> stretches);

}  // namespace isolux
