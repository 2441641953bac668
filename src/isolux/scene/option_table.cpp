#include "isolux/scene/option_table.h"

#include <algorithm>

namespace isolux {
namespace {

using enum ValueType;

constexpr double kFarthest_mm = 1e9;
constexpr double kLargestVoxelCount = 1 << 20;

Option coefficient(const char* name, const char* sentence, const char* default_text) {
  return {.name = name,
          .type = kColor,
          .sentence = sentence,
          .default_text = default_text,
          .low = 0,
          .high = 1};
}

Option place(const char* name, const char* sentence) {
  return {.name = name,
          .type = kVector,
          .sentence = sentence,
          .low = -kFarthest_mm,
          .high = kFarthest_mm};
}

Option choice(const char* name, const char* sentence, std::vector<std::string> choices,
              const char* default_text) {
  return {.name = name,
          .type = kChoice,
          .sentence = sentence,
          .default_text = default_text,
          .choices = std::move(choices)};
}

// An option that this version refuses, whatever its value.
Option later(Option option, const char* not_yet) {
  option.not_yet = not_yet;
  return option;
}

Option input_number(const char* sentence) {
  return {.name = "input", .type = kWhole, .sentence = sentence, .low = 1, .high = 1e6};
}

Option surface_option() {
  return {.name = "surface",
          .type = kRecord,
          .sentence =
              "draw the isosurface of a volume at a value; without iso: a mesh with other "
              "coefficients than its file's",
          .repeatable = true,
          .fields = {
              {.name = "iso",
               .type = kNumber,
               .sentence = "the iso value, in the file's own units",
               .low = -1e30,
               .high = 1e30},
              input_number("which INPUT it belongs to, counted from 1 (default: the first volume)"),
              coefficient("ka", "ambient coefficient", "0.1:0.1:0.1"),
              coefficient("kd", "diffuse coefficient (Lambert)", "0.8:0.8:0.8"),
              coefficient("ks", "specular coefficient (Phong)", "0.3:0.3:0.3"),
              coefficient("kr", "mirror coefficient", "0:0:0"),
              {.name = "shininess",
               .type = kNumber,
               .sentence = "Phong's exponent",
               .default_text = "40",
               .low = 0,
               .high = 1e6},
              {.name = "opacity",
               .type = kNumber,
               .sentence = "how much of what lies behind it hides",
               .default_text = "1",
               .low = 0,
               .high = 1},
          }};
}

Option light_option() {
  return {.name = "light",
          .type = kRecord,
          .sentence = "add a light; without any, one headlight shines from the eye",
          .repeatable = true,
          .fields =
              {
                  {.name = "kind",
                   .type = kChoice,
                   .sentence = "what light it is",
                   .choices = {"point", "directional"}},
                  place("at", "where a point light is"),
                  place("to", "the vector towards a directional light"),
                  {.name = "color",
                   .type = kColor,
                   .sentence = "its colour",
                   .default_text = "1:1:1",
                   .low = 0,
                   .high = 1e9},
                  {.name = "intensity",
                   .type = kNumber,
                   .sentence = "a factor on the colour",
                   .default_text = "1",
                   .low = 0,
                   .high = 1e9},
                  choice("space", "the space of at or to: millimetres, or voxel indices",
                         {"world", "index"}, "world"),
                  input_number("whose voxel indices, with space=index (default: the first volume)"),
                  choice("attach", "camera: x right, y up, z towards the viewer, origin at the eye",
                         {"world", "camera"}, "world"),
                  choice("falloff", "how a point light weakens with distance",
                         {"none", "inverse-square"}, "none"),
                  {.name = "reference",
                   .type = kNumber,
                   .sentence = "the distance at which falloff=inverse-square leaves it as it is "
                               "(default 1000)",
                   .unit = "mm",
                   .low = 0,
                   .high = kFarthest_mm,
                   .low_excluded = true},
              },
          .kind_first = true};
}

Option camera_option() {
  return {.name = "camera",
          .type = kRecord,
          .sentence = "from where it is seen: a named view, or eye, target and up",
          .fields = {
              {.name = "view",
               .type = kChoice,
               .sentence = "a named view that fits all inputs; up is superior (default front)",
               .choices = {"front", "back", "left", "right", "top", "bottom"}},
              place("eye", "where the eye is, in mm"),
              place("target", "the point looked at (default: the middle of all inputs)"),
              place("up", "the direction that is up in the picture (default 0:0:1)"),
              choice("projection", "with or without perspective", {"perspective", "orthographic"},
                     "perspective"),
              {.name = "fov",
               .type = kNumber,
               .sentence = "vertical field of view, perspective only (default 30)",
               .unit = "degrees",
               .low = 0.001,
               .high = 179},
              {.name = "height",
               .type = kNumber,
               .sentence = "the picture's height in world units, orthographic only (default: fits)",
               .unit = "mm",
               .low = 0,
               .high = kFarthest_mm,
               .low_excluded = true},
          }};
}

std::vector<Option> make_scene_options() {
  return {
      {.name = "size",
       .type = kSize,
       .sentence = "width and height of the picture",
       .default_text = "1024x1024",
       .unit = "pixels",
       .low = 1,
       .high = 32768},
      surface_option(),
      light_option(),
      {.name = "ambient",
       .type = kColor,
       .sentence = "the ambient light Ia (default: the sum of the lights' intensities)",
       .low = 0,
       .high = 1e9},
      camera_option(),
      choice("display", "how radiance becomes a byte: the sRGB curve, or the number itself",
             {"srgb", "raw"}, "srgb"),
      {.name = "exposure",
       .type = kNumber,
       .sentence = "a factor on the radiance before display",
       .default_text = "1",
       .low = 0,
       .high = 1e9},
      {.name = "background",
       .type = kColor,
       .sentence = "what a pixel without surface shows",
       .default_text = "0:0:0",
       .low = 0,
       .high = 1e9},
      {.name = "dims",
       .type = kSize,
       .sentence = "voxels along x, y, z of headerless raw inputs",
       .low = 1,
       .high = kLargestVoxelCount,
       .parts = 3},
      {.name = "type",
       .type = kChoice,
       .sentence = "voxel type of headerless raw inputs",
       .choices = {"u8", "i16", "i16be", "u16", "u16be", "f32", "f32be"}},
      {.name = "spacing",
       .type = kVector,
       .sentence = "distance between voxel centres; in place of the file's own, if it has one",
       .unit = "mm",
       .low = 0,
       .high = kFarthest_mm,
       .low_excluded = true},
      {.name = "volume",
       .type = kWhole,
       .sentence = "which volume of a 4-D file, counted from 0 (default: the first)",
       .low = 0,
       .high = 1e6},
      {.name = "series",
       .type = kText,
       .sentence = "which series of a DICOM folder: its number in the list that `isolux info` "
                   "prints, or its UID (default: the largest)"},
      {.name = "crease",
       .type = kNumber,
       .sentence = "give a mesh without normals smooth ones, but not across edges sharper than "
                   "this (default: its triangles are flat)",
       .unit = "degrees",
       .low = 0,
       .high = 180},
      choice("shadows", "whether surfaces cast shadows", {"on", "off"}, "off"),
      choice("visibility",
             "how the surface in a pixel is found; raster draws an isosurface as the mesh that "
             "`isolux mesh` makes of it",
             {"raycast", "raster"}, "raycast"),
      {.name = "mirror-depth",
       .type = kWhole,
       .sentence = "how many reflections of reflections are followed",
       .default_text = "4",
       .low = 0,
       .high = 64},
      choice("indirect",
             "light that surfaces send to each other, in place of the ambient term: transport is "
             "cached and follows a moving lamp at once, path is without bias and converges with "
             "--spp",
             {"off", "transport", "path"}, "off"),
      {.name = "bounces",
       .type = kWhole,
       .sentence = "bounces of indirect light (default 2)",
       .low = 0,
       .high = 64},
      {.name = "spp",
       .type = kWhole,
       .sentence = "indirect samples a pixel, with --indirect path (default 64; with --error as "
                   "many as it takes)",
       .low = 1,
       .high = 1 << 20},
      {.name = "error",
       .type = kNumber,
       .sentence = "the relative standard error of indirect light to stop at, with --indirect path",
       .low = 0,
       .high = 1,
       .low_excluded = true},
      {.name = "indirect-memory",
       .type = kText,
       .sentence = "how much memory --indirect transport may take, such as 500M (default 1G)"},
      {.name = "seed",
       .type = kWhole,
       .sentence = "another set of random numbers, with --indirect path (default 0)",
       .low = 0,
       .high = 1e15},
      {.name = "denoise",
       .type = kChoice,
       .sentence = "take the noise out of indirect light, with --indirect path (default off)",
       .choices = {"on", "off"}},
      later({.name = "transfer", .type = kText, .sentence = "draw the volume itself as well"},
            "volumes drawn as volumes are not in this version"),
      later({.name = "clip",
             .type = kText,
             .sentence = "take away what lies beyond a plane",
             .repeatable = true},
            "clipping is not in this version"),
  };
}

// Levenshtein's distance.
std::size_t edits_between(const std::string& a, const std::string& b) {
  std::vector<std::size_t> row(b.size() + 1);
  for (std::size_t j = 0; j <= b.size(); ++j) row[j] = j;
  for (std::size_t i = 1; i <= a.size(); ++i) {
    std::size_t diagonal = row[0];
    row[0] = i;
    for (std::size_t j = 1; j <= b.size(); ++j) {
      const std::size_t replaced = diagonal + (a[i - 1] == b[j - 1] ? 0 : 1);
      diagonal = row[j];
      row[j] = std::min({replaced, row[j] + 1, row[j - 1] + 1});
    }
  }
  return row.back();
}

}  // namespace

const std::vector<Option>& scene_options() {
  static const std::vector<Option> options = make_scene_options();
  return options;
}

const Option* find_option(const std::vector<Option>& options, const std::string& name) {
  const auto found = std::ranges::find(options, name, &Option::name);
  return found == options.end() ? nullptr : &*found;
}

std::string nearest_name(const std::vector<Option>& options, const std::string& name) {
  std::string best;
  std::size_t best_edits = 3;
  for (const Option& option : options) {
    const std::size_t edits = edits_between(option.name, name);
    if (edits < best_edits) {
      best_edits = edits;
      best = option.name;
    }
  }
  return best;
}

}  // namespace isolux
