#pragma once

#include "isolux/io/reader.h"

namespace isolux {

/// What `isolux info` prints of a mesh.
void print_mesh_info(const ReadResult& input, bool as_json);

}  // namespace isolux
