#include "isolux/bench/mesh_works.h"

#include "isolux/bench/scene_works.h"
#include "isolux/bench/timing.h"
#include "isolux/mesh/extract_isosurface.h"
#include "isolux/mesh/mesh_box.h"
#include "isolux/mesh/smooth_normals.h"

namespace isolux {
namespace {

Scene with_visibility(Scene scene, Visibility visibility) {
  scene.visibility = visibility;
  return scene;
}

void make_white(Mesh& mesh) {
  mesh.materials.assign(1, {});
  mesh.parts = {{0, static_cast<std::uint32_t>(mesh.triangles.size()), 0}};
}

std::vector<float> numbers_of(const std::vector<Vec3f>& vectors) {
  std::vector<float> numbers;
  numbers.reserve(3 * vectors.size());
  for (const Vec3f& v : vectors) numbers.insert(numbers.end(), {v.x, v.y, v.z});
  return numbers;
}

std::vector<Vec3f> vectors_of(const std::vector<float>& numbers) {
  std::vector<Vec3f> vectors(numbers.size() / 3);
  for (std::size_t n = 0; n < vectors.size(); ++n) {
    vectors[n] = {numbers[3 * n], numbers[3 * n + 1], numbers[3 * n + 2]};
  }
  return vectors;
}

}  // namespace

MeshRenderers::MeshRenderers(Scene scene)
    : raycast(with_visibility(scene, Visibility::kRaycast)),
      raster(with_visibility(std::move(scene), Visibility::kRaster)) {
  for (OwnRenderer* renderer : {&raycast, &raster}) {
    renderer->prepare();
    renderer->frame();
  }
}

std::shared_ptr<const Mesh> extracted_mesh(const Scene& scene) {
  const SurfaceItem& surface = scene.surfaces[0];
  Mesh mesh = extract_isosurface(*surface.volume, surface.iso);
  make_white(mesh);
  return std::make_shared<const Mesh>(std::move(mesh));
}

Scene on_mesh(Scene scene, std::shared_ptr<const Mesh> mesh) {
  scene.surfaces = {{.volume = nullptr, .material = {}, .mesh = std::move(mesh)}};
  return scene;
}

std::shared_ptr<const Mesh> bare_mesh(const Mesh& mesh) {
  Mesh bare;
  const MeshBox box = box_of(mesh);
  constexpr double kDiagonalOfHead = 350;  // mm
  const double scale = kDiagonalOfHead / length(box.high - box.low);
  for (const Vec3f& position : mesh.positions) {
    bare.positions.push_back(as_float(scale * (as_double(position) - box.low)));
  }
  bare.normals = mesh.normals;
  bare.triangles = mesh.triangles;
  make_white(bare);
  if (bare.normals.empty()) bare = with_smooth_normals(bare, 180);
  return std::make_shared<const Mesh>(std::move(bare));
}

PeerMesh peer_mesh(const Mesh& mesh) {
  PeerMesh to{numbers_of(mesh.positions), numbers_of(mesh.normals), {}};
  for (const Mesh::Triangle& t : mesh.triangles) {
    to.triangles.insert(to.triangles.end(), t.begin(), t.end());
  }
  return to;
}

std::shared_ptr<const Mesh> mesh_from_peer(const PeerMesh& mesh) {
  Mesh to;
  to.positions = vectors_of(mesh.positions);
  to.normals = vectors_of(mesh.normals);
  for (std::size_t n = 0; n + 2 < mesh.triangles.size(); n += 3) {
    to.triangles.push_back({mesh.triangles[n], mesh.triangles[n + 1], mesh.triangles[n + 2]});
  }
  make_white(to);
  return std::make_shared<const Mesh>(std::move(to));
}

Work extraction_work(const OwnRenderer& of_volume, int turns) {
  const SurfaceItem surface = of_volume.scene().surfaces[0];
  return {"extraction", turns, [surface](int turn) {
            const double iso = iso_of_turn(surface.iso, turn);
            return milliseconds([&] { extract_isosurface(*surface.volume, iso); });
          }};
}

Work tree_work(const MeshRenderers& renderers, int turns) {
  return {"mesh tree", turns, [&renderers](int) {
            OwnRenderer fresh(renderers.raycast.scene());
            return milliseconds([&] { fresh.prepare(); });
          }};
}

std::vector<Work> mesh_works(MeshRenderers& renderers, int turns) {
  std::vector<Work> works{tree_work(renderers, turns)};
  for (const auto& [name, renderer] : {std::pair{"mesh frame, raycast", &renderers.raycast},
                                       std::pair{"mesh frame, raster", &renderers.raster}}) {
    works.push_back(frame_work(*renderer, turns));
    works.back().name = name;
  }
  works.back().others = {
      {"raycast", [&renderers](int) { return milliseconds([&] { renderers.raycast.frame(); }); }}};
  for (Work& work : ray_works(renderers.raycast, turns)) {
    work.name += " on mesh";
    works.push_back(std::move(work));
  }
  return works;
}

}  // namespace isolux
