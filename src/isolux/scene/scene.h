#pragma once

#include <memory>
#include <optional>
#include <vector>

#include "isolux/mesh/mesh.h"
#include "isolux/scene/camera.h"
#include "isolux/scene/description.h"
#include "isolux/shade/light.h"
#include "isolux/shade/material.h"
#include "isolux/volume/volume.h"

namespace isolux {

/// What was read of one input: a volume or a mesh; the other is null.
struct SceneInput {
  std::shared_ptr<const Volume> volume;
  std::shared_ptr<const Mesh> mesh = nullptr;

  bool operator==(const SceneInput&) const = default;
};

/// An isosurface of a loaded volume, or a mesh. Its number is its place in Scene::surfaces.
struct SurfaceItem {
  std::shared_ptr<const Volume> volume;  ///< null where it is a mesh
  std::size_t input = 0;                 ///< counted from 0
  double iso = 0;
  Material material;  ///< but for a painted mesh
  std::shared_ptr<const Mesh> mesh = nullptr;
  /// A mesh whose material is not the same all over; see material_at.
  bool is_painted = false;
  MaterialChange change = {};  ///< what takes the place of its own coefficients
};

/// The material at a point of a surface; only meshes look at the point.
Material material_at(const SurfaceItem& item, const MeshPoint& point);

/// What is to be drawn, all in world space: plain data, with the volumes it needs.
struct Scene : SecondaryRays {
  std::vector<SurfaceItem> surfaces;
  std::vector<Light> lights;
  bool has_default_light = false;    ///< the headlight that shines when no light was asked for
  Rgb ambient;                       ///< Ia
  bool has_default_ambient = false;  ///< Ia is the sum of the lights' intensities
  std::optional<Camera> camera;      ///< always there once resolved
  Visibility visibility = Visibility::kRaycast;
  Display display;
  Rgb background;
};

/// The sphere that named views fit.
BoundingSphere bounding_sphere(const std::vector<SceneInput>& inputs);

/// Puts what was loaded (one for each input, in order) and a description together: surfaces get
/// their volumes and meshes, lights their place in world space, named views their distance.
/// Surfaces are those that the description names, in its order; the first suggested isosurface of
/// every volume where it names none of any; and the meshes that it does not name.
/// @throws UsageError  where an input=K names no input or one of the other kind; WorkError where a
/// volume suggests no iso value.
Scene resolve(const SceneDescription& description, const std::vector<SceneInput>& inputs);

}  // namespace isolux
