#pragma once

#include <string>

#include "isolux/base/fence.h"
#include "isolux/io/stored_voxels.h"

namespace isolux {

/// Bytes that a library reads from a file inside a fence (isolux/base/fence.h): `work` sends them,
/// in order, each time that it is asked to.
/// @throws WorkError  (when read) about `path`, where the library comes to grief; and what `work`
/// throws of that kind.
ReadNext read_fenced(const std::string& path, double memory,
                     const std::function<void(FenceOutput&)>& work);

}  // namespace isolux
