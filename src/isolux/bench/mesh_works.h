#pragma once

#include <memory>
#include <vector>

#include "isolux/bench/mesh_file.h"
#include "isolux/bench/own_renderer.h"
#include "isolux/bench/work.h"
#include "isolux/mesh/mesh.h"

// The works of triangles: extracting them, and drawing them by rays and by rasterisation.

namespace isolux {

/// One scene, whose surfaces are meshes, drawn in both ways. Each has drawn a frame.
struct MeshRenderers {
  explicit MeshRenderers(Scene scene);

  OwnRenderer raycast, raster;
};

/// The first surface of a scene, an isosurface, as the mesh that isolux extracts; white.
std::shared_ptr<const Mesh> extracted_mesh(const Scene& scene);
/// The same scene with that mesh for its only surface.
Scene on_mesh(Scene scene, std::shared_ptr<const Mesh> mesh);

/// Nothing but triangles and normals, which are made smooth where it has none; its box begins at
/// the origin and is as large as that of a head. What every peer can draw.
std::shared_ptr<const Mesh> bare_mesh(const Mesh& mesh);
PeerMesh peer_mesh(const Mesh& mesh);
std::shared_ptr<const Mesh> mesh_from_peer(const PeerMesh& mesh);

/// From the voxels to the mesh with its normals.
Work extraction_work(const OwnRenderer& of_volume, int turns);
/// From the mesh to Embree's tree.
Work tree_work(const MeshRenderers& renderers, int turns);

/// The tree, a frame in each way (and both in turns), and rays of no picture. They keep
/// `renderers`.
std::vector<Work> mesh_works(MeshRenderers& renderers, int turns);

}  // namespace isolux
