#include "isolux/scene/scene.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "isolux/base/error.h"
#include "isolux/volume/statistics.h"

namespace isolux {
namespace {

using Volumes = std::vector<std::shared_ptr<const Volume>>;

std::size_t input_index(std::optional<int> input, const Volumes& volumes, const char* what) {
  const std::size_t index = static_cast<std::size_t>(input.value_or(1)) - 1;
  if (index >= volumes.size()) {
    throw UsageError(what, "input=" + std::to_string(index + 1) + " is not there",
                     "inputs are counted from 1, and " + std::to_string(volumes.size()) +
                         (volumes.size() == 1 ? " was given" : " were given"));
  }
  return index;
}

Light resolve_light(const LightDescription& light, const Volumes& volumes, const Camera& camera) {
  Affine to_world;
  if (light.in_index_space) {
    to_world = volumes[input_index(light.input, volumes, "--light")]->world_from_index;
  } else if (light.on_camera) {
    to_world = camera.world_from_camera();
  }
  return {light.is_point ? Light::Kind::kPoint : Light::Kind::kDirectional,
          light.is_point ? to_world.point(light.place) : to_world.vector(light.place),
          light.intensity * light.color, light.inverse_square_reference_mm};
}

std::vector<IsoSurfaceItem> resolve_surfaces(const SceneDescription& description,
                                             const Volumes& volumes) {
  for (std::size_t index = 0; index < volumes.size(); ++index) {
    const auto [nx, ny, nz] = volumes[index]->dims;
    if (has_cells(*volumes[index])) continue;
    throw WorkError(description.inputs[index],
                    std::to_string(nx) + "x" + std::to_string(ny) + "x" + std::to_string(nz) +
                        " voxels hold no surface",
                    "a volume needs at least 2 voxels along each axis");
  }
  std::vector<IsoSurfaceItem> items;
  for (const SurfaceDescription& surface : description.surfaces) {
    const std::size_t index = input_index(surface.input, volumes, "--surface");
    items.push_back({volumes[index], index, surface.iso, surface.material});
  }
  if (!items.empty()) return items;
  for (std::size_t index = 0; index < volumes.size(); ++index) {
    const Volume& volume = *volumes[index];
    const auto suggested = suggest_iso(volume, value_statistics(volume));
    if (suggested.empty()) {
      throw WorkError(description.inputs[index], "all its voxels have one value",
                      "there is no surface to draw");
    }
    items.push_back({volumes[index], index, suggested[0].value, Material{}});
  }
  return items;
}

}  // namespace

BoundingSphere bounding_sphere(const Volumes& volumes) {
  constexpr double kInfinity = std::numeric_limits<double>::infinity();
  Vec3 low{kInfinity, kInfinity, kInfinity};
  Vec3 high = -low;
  for (const auto& volume : volumes) {
    for (const Vec3& corner : box_corners(*volume)) {
      for (int axis = 0; axis < 3; ++axis) {
        low[axis] = std::min(low[axis], corner[axis]);
        high[axis] = std::max(high[axis], corner[axis]);
      }
    }
  }
  BoundingSphere sphere{0.5 * (low + high), 0};
  for (const auto& volume : volumes) {
    for (const Vec3& corner : box_corners(*volume)) {
      sphere.radius_mm = std::max(sphere.radius_mm, length(corner - sphere.center));
    }
  }
  if (sphere.radius_mm == 0) sphere.radius_mm = 1;  // a lone voxel
  return sphere;
}

Scene resolve(const SceneDescription& description, const Volumes& volumes) {
  Scene scene;
  scene.camera.emplace(description.camera, description.width, description.height,
                       bounding_sphere(volumes));
  scene.surfaces = resolve_surfaces(description, volumes);
  for (const LightDescription& light : description.lights) {
    scene.lights.push_back(resolve_light(light, volumes, *scene.camera));
  }
  if (scene.lights.empty()) {
    scene.has_default_light = true;
    scene.lights.push_back(
        resolve_light({.place = {0, 0, 1}, .on_camera = true}, volumes, *scene.camera));
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
