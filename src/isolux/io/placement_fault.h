#pragma once

#include <string>

#include "isolux/base/affine.h"

namespace isolux {

/// Why an affine cannot place voxels, as a verb ("is singular: ..."); empty where it can.
std::string placement_fault(const Affine& world_from_index);

}  // namespace isolux
