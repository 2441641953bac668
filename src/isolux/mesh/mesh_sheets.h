#pragma once

#include <cstdint>
#include <vector>

#include "isolux/mesh/mesh.h"

namespace isolux {

/// Which sheet each triangle belongs to: triangles hang together where they share a vertex's place.
/// Sheets count from 0 in the order of their first triangles.
std::vector<std::uint32_t> sheets_of(const Mesh& mesh);

}  // namespace isolux
