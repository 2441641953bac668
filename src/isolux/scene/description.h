#pragma once

#include <array>
#include <cstdint>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>
#include <vector>

#include "isolux/base/rgb.h"
#include "isolux/base/vec3.h"
#include "isolux/image/display.h"
#include "isolux/shade/material.h"

namespace isolux {

/// Coefficients that take the place of others.
struct MaterialChange {
  std::optional<Rgb> ka = {}, kd = {}, ks = {}, kr = {};
  std::optional<double> shininess = {}, opacity = {};

  Material applied(Material to) const;
  bool operator==(const MaterialChange&) const = default;
};

struct SurfaceDescription {
  std::optional<double> iso;  ///< nothing: it is a mesh
  std::optional<int> input;   ///< counted from 1; nothing: the first volume
  MaterialChange change;      ///< for an isosurface: everything
};

/// How light that surfaces send to each other is found.
enum class IndirectMethod { kOff, kTransport, kPath };

/// How the surface in a pixel is found.
enum class Visibility { kRaycast, kRaster };

struct LightDescription {
  bool is_point = false;
  Vec3 place;  ///< a point light's position, or the vector to a directional light
  Rgb color{1, 1, 1};
  double intensity = 1;
  bool in_index_space = false;
  std::optional<int> input = {};  ///< whose index space, counted from 1
  bool on_camera = false;
  std::optional<double> inverse_square_reference_mm = {};
};

struct CameraDescription {
  std::optional<std::string> view = {};  ///< front, back, left, right, top, bottom
  std::optional<Vec3> eye = {}, target = {}, up = {};
  bool orthographic = false;
  double fov_deg = 30;
  std::optional<double> height_mm = {};
};

/// How inputs are to be read: the grid of headerless raw files, a spacing in place of a file's own,
/// which of several volumes in a file, and how smooth a mesh is that does not say.
struct GridDescription {
  std::optional<std::array<int, 3>> dims;
  std::optional<std::string> type;  ///< as in the option table: "i16be"
  std::optional<Vec3> spacing_mm;
  std::optional<int> volume;          ///< of a 4-D file, counted from 0
  std::optional<std::string> series;  ///< of a DICOM folder: its number in the list, from 1, or UID
  std::optional<double> crease_deg;   ///< of a mesh without normals: sharper edges stay edges
};

/// How light that surfaces send to each other is asked for.
struct IndirectDescription {
  IndirectMethod indirect = IndirectMethod::kOff;
  int bounces = 2;
  int spp = 64;                               ///< samples a pixel; with an error: at most
  std::optional<double> indirect_error = {};  ///< relative standard error to stop at
  std::uint64_t seed = 0;
  bool denoise = false;          ///< whether noise is taken out of what paths have brought
  double indirect_memory = 1e9;  ///< bytes that cached transport may take
};

/// What rays from surfaces are asked for.
struct SecondaryRays : IndirectDescription {
  bool shadows = false;
  int mirror_depth = 4;  ///< reflections of reflections that are followed
};

/// All that a scene document says, typed and checked for sense, with nothing loaded.
struct SceneDescription : SecondaryRays {
  std::vector<std::string> inputs;
  GridDescription grid;
  int width = 0;
  int height = 0;
  std::vector<SurfaceDescription> surfaces;
  std::vector<LightDescription> lights;
  std::optional<Rgb> ambient;
  CameraDescription camera;
  Visibility visibility = Visibility::kRaycast;
  Display display;
  Rgb background;
};

/// @throws UsageError  where the document is not valid (see check_document), or its parts do not go
/// together, such as a falloff on a directional light. `what` names where the document came from.
SceneDescription describe(const nlohmann::json& document, const std::string& what);

}  // namespace isolux
