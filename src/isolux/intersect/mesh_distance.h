#pragma once

#include "isolux/intersect/iso_surface.h"
#include "isolux/mesh/mesh.h"

namespace isolux {

/// How far the triangles of a mesh are from the exact isosurface that its vertices lie on, measured
/// from their centroids: to the first root along the normal (of the vertices together, or of the
/// triangle), in both directions, or to the nearest vertex, if that is closer.
struct MeshDistance {
  double mean_mm = 0;
  double greatest_mm = 0;
};

MeshDistance distance_between(const Mesh& mesh, const IsoSurface& surface);

}  // namespace isolux
