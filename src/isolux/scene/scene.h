#pragma once

#include <memory>
#include <optional>
#include <vector>

#include "isolux/scene/camera.h"
#include "isolux/scene/description.h"
#include "isolux/shade/light.h"
#include "isolux/shade/material.h"
#include "isolux/volume/volume.h"

namespace isolux {

/// An isosurface of a loaded volume. Its number is its place in Scene::surfaces.
struct IsoSurfaceItem {
  std::shared_ptr<const Volume> volume;
  std::size_t input = 0;  ///< counted from 0
  double iso = 0;
  Material material;
};

/// What is to be drawn, all in world space: plain data, with the volumes it needs.
struct Scene {
  std::vector<IsoSurfaceItem> surfaces;
  std::vector<Light> lights;
  bool has_default_light = false;    ///< the headlight that shines when no light was asked for
  Rgb ambient;                       ///< Ia
  bool has_default_ambient = false;  ///< Ia is the sum of the lights' intensities
  std::optional<Camera> camera;      ///< always there once resolved
  Display display;
  Rgb background;
};

/// The sphere that named views fit.
BoundingSphere bounding_sphere(const std::vector<std::shared_ptr<const Volume>>& volumes);

/// Puts loaded volumes (one for each input, in order) and a description together: surfaces get
/// their volumes, lights their place in world space, named views their distance.
/// @throws UsageError  where an input=K names no input, or a volume suggests no iso value.
Scene resolve(const SceneDescription& description,
              const std::vector<std::shared_ptr<const Volume>>& volumes);

}  // namespace isolux
