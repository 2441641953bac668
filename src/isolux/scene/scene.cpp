#include "isolux/scene/scene.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "isolux/base/error.h"
#include "isolux/mesh/mesh_attributes.h"
#include "isolux/mesh/mesh_box.h"
#include "isolux/volume/statistics.h"

namespace isolux {
namespace {

using Inputs = std::vector<SceneInput>;

// The first volume's place; the first input's, where all are meshes.
std::size_t first_volume(const Inputs& inputs) {
  const auto found =
      std::ranges::find_if(inputs, [](const auto& i) { return i.volume != nullptr; });
  return found == inputs.end() ? 0 : static_cast<std::size_t>(found - inputs.begin());
}

std::size_t input_index(std::optional<int> input, const Inputs& inputs, const char* what) {
  if (!input) return first_volume(inputs);
  const std::size_t index = static_cast<std::size_t>(*input) - 1;
  if (index >= inputs.size()) {
    throw UsageError(what, "input=" + std::to_string(index + 1) + " is not there",
                     "inputs are counted from 1, and " + std::to_string(inputs.size()) +
                         (inputs.size() == 1 ? " was given" : " were given"));
  }
  return index;
}

std::array<Vec3, 8> corners_of(const SceneInput& input) {
  if (input.volume) return box_corners(*input.volume);
  const MeshBox box = box_of(*input.mesh);
  std::array<Vec3, 8> corners;
  for (std::size_t c = 0; c < 8; ++c) {
    corners[c] = {c & 1 ? box.high.x : box.low.x, c & 2 ? box.high.y : box.low.y,
                  c & 4 ? box.high.z : box.low.z};
  }
  return corners;
}

Light resolve_light(const LightDescription& light, const Inputs& inputs, const Camera& camera) {
  Affine to_world;
  if (light.in_index_space) {
    const auto& volume = inputs[input_index(light.input, inputs, "--light")].volume;
    if (!volume) {
      throw UsageError("--light", "space=index needs a volume, and this input is a mesh",
                       "give its place in mm");
    }
    to_world = volume->world_from_index;
  } else if (light.on_camera) {
    to_world = camera.world_from_camera();
  }
  return {light.is_point ? Light::Kind::kPoint : Light::Kind::kDirectional,
          light.is_point ? to_world.point(light.place) : to_world.vector(light.place),
          light.intensity * light.color, light.inverse_square_reference_mm};
}

void require_cells(const std::string& name, const Volume& volume) {
  if (has_cells(volume)) return;
  const auto [nx, ny, nz] = volume.dims;
  throw WorkError(name,
                  std::to_string(nx) + "x" + std::to_string(ny) + "x" + std::to_string(nz) +
                      " voxels hold no surface",
                  "a volume needs at least 2 voxels along each axis");
}

SurfaceItem mesh_item(const SceneInput& input, std::size_t index, const MaterialChange& change) {
  SurfaceItem item;
  item.input = index;
  item.mesh = input.mesh;
  item.change = change;
  item.is_painted = !has_one_material(*input.mesh);
  item.material = change.applied(material_at(*input.mesh, {}));
  return item;
}

SurfaceItem named_item(const SurfaceDescription& surface, const Inputs& inputs) {
  const std::size_t index = input_index(surface.input, inputs, "--surface");
  const SceneInput& input = inputs[index];
  const std::string number = "input " + std::to_string(index + 1);
  if (input.volume && !surface.iso) {
    throw UsageError("--surface", number + " is a volume and needs an iso value",
                     "give iso=V; `isolux info` suggests values");
  }
  if (input.mesh && surface.iso) {
    throw UsageError("--surface", number + " is a mesh and has no iso value", "leave iso out");
  }
  if (input.mesh) return mesh_item(input, index, surface.change);
  return {input.volume, index, *surface.iso, surface.change.applied({})};
}

SurfaceItem suggested_item(const std::string& name, const SceneInput& input, std::size_t index) {
  const auto suggested = suggest_iso(*input.volume, value_statistics(*input.volume));
  if (suggested.empty()) {
    throw WorkError(name, "all its voxels have one value", "there is no surface to draw");
  }
  return {input.volume, index, suggested[0].value, Material{}};
}

std::vector<SurfaceItem> resolve_surfaces(const SceneDescription& description,
                                          const Inputs& inputs) {
  for (std::size_t n = 0; n < inputs.size(); ++n) {
    if (inputs[n].volume) require_cells(description.inputs[n], *inputs[n].volume);
  }
  std::vector<SurfaceItem> items;
  for (const SurfaceDescription& surface : description.surfaces) {
    items.push_back(named_item(surface, inputs));
  }
  const auto is_volume = [](const SurfaceItem& item) { return item.volume != nullptr; };
  const bool names_volumes = std::ranges::any_of(items, is_volume);
  for (std::size_t n = 0; n < inputs.size(); ++n) {
    if (!inputs[n].volume || names_volumes) continue;
    items.push_back(suggested_item(description.inputs[n], inputs[n], n));
  }
  for (std::size_t n = 0; n < inputs.size(); ++n) {
    const auto is_it = [&](const SurfaceItem& item) { return item.input == n; };
    if (inputs[n].mesh && std::ranges::none_of(items, is_it)) {
      items.push_back(mesh_item(inputs[n], n, {}));
    }
  }
  return items;
}

}  // namespace

Material material_at(const SurfaceItem& item, const MeshPoint& point) {
  return item.is_painted ? item.change.applied(material_at(*item.mesh, point)) : item.material;
}

BoundingSphere bounding_sphere(const Inputs& inputs) {
  constexpr double kInfinity = std::numeric_limits<double>::infinity();
  Vec3 low{kInfinity, kInfinity, kInfinity};
  Vec3 high = -low;
  for (const SceneInput& input : inputs) {
    for (const Vec3& corner : corners_of(input)) {
      for (int axis = 0; axis < 3; ++axis) {
        low[axis] = std::min(low[axis], corner[axis]);
        high[axis] = std::max(high[axis], corner[axis]);
      }
    }
  }
  BoundingSphere sphere{0.5 * (low + high), 0};
  for (const SceneInput& input : inputs) {
    for (const Vec3& corner : corners_of(input)) {
      sphere.radius_mm = std::max(sphere.radius_mm, length(corner - sphere.center));
    }
  }
  if (sphere.radius_mm == 0) sphere.radius_mm = 1;  // a lone voxel
  return sphere;
}

Scene resolve(const SceneDescription& description, const Inputs& inputs) {
  Scene scene;
  scene.visibility = description.visibility;
  static_cast<SecondaryRays&>(scene) = description;
  scene.camera.emplace(description.camera, description.width, description.height,
                       bounding_sphere(inputs));
  scene.surfaces = resolve_surfaces(description, inputs);
  for (const LightDescription& light : description.lights) {
    scene.lights.push_back(resolve_light(light, inputs, *scene.camera));
  }
  if (scene.lights.empty()) {
    scene.has_default_light = true;
    scene.lights.push_back(
        resolve_light({.place = {0, 0, 1}, .on_camera = true}, inputs, *scene.camera));
  }
  scene.has_default_ambient = !description.ambient;
  if (description.ambient) {
    scene.ambient = *description.ambient;
  } else {
    for (const Light& light : scene.lights) scene.ambient = scene.ambient + light.intensity;
  }
  scene.display = description.display;
  scene.background = description.background;
  return scene;
}

}  // namespace isolux
