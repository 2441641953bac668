#include "isolux/scene/description.h"

#include <nlohmann/json.hpp>

#include "isolux/base/error.h"
#include "isolux/base/memory.h"
#include "isolux/scene/document.h"

namespace isolux {
namespace {

using nlohmann::json;

Vec3 vector_of(const json& value) {
  return {value[0].get<double>(), value[1].get<double>(), value[2].get<double>()};
}

Rgb color_of(const json& value) {
  return {value[0].get<double>(), value[1].get<double>(), value[2].get<double>()};
}

std::optional<Vec3> optional_vector(const json& record, const char* key) {
  if (!record.contains(key)) return std::nullopt;
  return vector_of(record[key]);
}

std::optional<int> optional_whole(const json& record, const char* key) {
  if (!record.contains(key)) return std::nullopt;
  return record[key].get<int>();
}

std::optional<double> optional_number(const json& record, const char* key) {
  if (!record.contains(key)) return std::nullopt;
  return record[key].get<double>();
}

std::optional<Rgb> optional_color(const json& record, const char* key) {
  if (!record.contains(key)) return std::nullopt;
  return color_of(record[key]);
}

SurfaceDescription describe_surface(const json& record) {
  return {.iso = optional_number(record, "iso"),
          .input = optional_whole(record, "input"),
          .change = {.ka = optional_color(record, "ka"),
                     .kd = optional_color(record, "kd"),
                     .ks = optional_color(record, "ks"),
                     .kr = optional_color(record, "kr"),
                     .shininess = optional_number(record, "shininess"),
                     .opacity = optional_number(record, "opacity")}};
}

void refuse(const json& record, const char* key, const std::string& what, const char* why,
            const char* hint) {
  if (record.contains(key)) throw UsageError(what, std::string(key) + " " + why, hint);
}

LightDescription describe_light(const json& given, const json& record, const std::string& what) {
  if (!record.contains("kind")) {
    throw UsageError(what, "does not say what light it is",
                     "begin with point,at=X:Y:Z or directional,to=X:Y:Z");
  }
  LightDescription light;
  light.is_point = record["kind"] == "point";
  const char* place_key = light.is_point ? "at" : "to";
  if (light.is_point) {
    refuse(record, "to", what, "belongs to a directional light", "a point light takes at=X:Y:Z");
  } else {
    refuse(record, "at", what, "belongs to a point light", "a directional light takes to=X:Y:Z");
    if (record["falloff"] != "none") {
      throw UsageError(what, "a directional light has no distance to fall off with",
                       "leave falloff out, or use a point light");
    }
  }
  if (!record.contains(place_key)) {
    throw UsageError(
        what, std::string("has no ") + place_key + "=X:Y:Z",
        light.is_point ? "say where the point light is" : "give the vector towards the light");
  }
  light.place = vector_of(record[place_key]);
  if (!light.is_point && light.place == Vec3{}) {
    throw UsageError(what, "to=0:0:0 is no direction", "give the vector towards the light");
  }
  light.color = color_of(record["color"]);
  light.intensity = record["intensity"].get<double>();
  light.in_index_space = record["space"] == "index";
  light.on_camera = record["attach"] == "camera";
  light.input = optional_whole(record, "input");
  if (light.in_index_space && light.on_camera) {
    throw UsageError(what, "space=index and attach=camera exclude each other", "leave one out");
  }
  if (!light.in_index_space) {
    refuse(record, "input", what, "says whose voxel indices are meant", "add space=index");
  }
  if (record["falloff"] == "inverse-square") {
    light.inverse_square_reference_mm = optional_number(record, "reference").value_or(1000);
  } else {
    refuse(given, "reference", what, "is the distance of a falloff", "add falloff=inverse-square");
  }
  return light;
}

CameraDescription describe_camera(const json& record, const std::string& what) {
  CameraDescription camera;
  camera.eye = optional_vector(record, "eye");
  camera.target = optional_vector(record, "target");
  camera.up = optional_vector(record, "up");
  camera.height_mm = optional_number(record, "height");
  camera.orthographic = record.contains("projection") && record["projection"] == "orthographic";
  if (record.contains("view")) {
    for (const char* key : {"eye", "target", "up"}) {
      refuse(record, key, what, "does not go with view=...", "give a named view, or eye=...");
    }
    camera.view = record["view"].get<std::string>();
  } else if (!camera.eye) {
    for (const char* key : {"target", "up"}) {
      refuse(record, key, what, "needs eye=X:Y:Z", "say where the eye is as well");
    }
    camera.view = "front";
  }
  if (camera.orthographic) {
    refuse(record, "fov", what, "has no meaning without perspective",
           "an orthographic camera takes height=MM");
  } else {
    refuse(record, "height", what, "is for projection=orthographic",
           "a perspective camera takes fov=DEG");
    camera.fov_deg = optional_number(record, "fov").value_or(30);
  }
  return camera;
}

template <typename Describe>
void for_each_item(const json& document, const json& complete, const char* key,
                   const Describe& describe_item) {
  if (!complete.contains(key)) return;
  for (std::size_t n = 0; n < complete[key].size(); ++n) {
    const std::string number =
        complete[key].size() > 1 ? " " + std::to_string(n + 1) : std::string();
    describe_item(document[key][n], complete[key][n], std::string("--") + key + number);
  }
}

}  // namespace

Material MaterialChange::applied(Material to) const {
  to.ka = ka.value_or(to.ka);
  to.kd = kd.value_or(to.kd);
  to.ks = ks.value_or(to.ks);
  to.kr = kr.value_or(to.kr);
  to.shininess = shininess.value_or(to.shininess);
  to.opacity = opacity.value_or(to.opacity);
  return to;
}

namespace {

// Options that mean something beside others alone are refused without them.
void describe_indirect(const json& given, const json& complete, SceneDescription& scene) {
  const bool is_path = complete["indirect"] == "path";
  const bool is_transport = complete["indirect"] == "transport";
  if (is_transport) scene.indirect = IndirectMethod::kTransport;
  if (is_path) scene.indirect = IndirectMethod::kPath;
  if (complete["indirect"] == "off") {
    refuse(given, "bounces", "--bounces", "counts those of indirect light",
           "add --indirect transport");
  }
  if (!is_transport) {
    refuse(given, "indirect-memory", "--indirect-memory", "belongs to cached transport",
           "add --indirect transport");
  }
  for (const char* name : {"spp", "error", "seed"}) {
    if (is_path) break;
    refuse(given, name, std::string("--") + name, "belongs to the path tracer",
           "add --indirect path");
  }
  scene.bounces = optional_whole(complete, "bounces").value_or(scene.bounces);
  scene.indirect_error = optional_number(complete, "error");
  constexpr int kMost = 1 << 16;
  constexpr double kLeastMemory = 1e4;
  const int most = scene.indirect_error && !given.contains("spp") ? kMost : 64;
  scene.spp = optional_whole(complete, "spp").value_or(most);
  if (complete.contains("indirect-memory")) {
    const auto memory = parse_memory(complete["indirect-memory"].get<std::string>());
    if (!memory || *memory < kLeastMemory) {
      throw UsageError("--indirect-memory", "is no size of 10k or more", "write 500M");
    }
    scene.indirect_memory = *memory;
  }
  scene.denoise = complete.value("denoise", "off") == "on";
  if (scene.denoise && !is_path) {
    throw UsageError("--denoise", "takes out the noise of paths", "add --indirect path");
  }
  scene.seed = complete.value("seed", std::uint64_t{0});
}

}  // namespace

SceneDescription describe(const json& document, const std::string& what) {
  check_document(document, what);
  const json complete = with_defaults(document);
  SceneDescription scene;
  if (complete.contains("input")) scene.inputs = complete["input"].get<std::vector<std::string>>();
  scene.grid.spacing_mm = optional_vector(complete, "spacing");
  if (complete.contains("dims")) scene.grid.dims = complete["dims"].get<std::array<int, 3>>();
  if (complete.contains("type")) scene.grid.type = complete["type"].get<std::string>();
  scene.grid.volume = optional_whole(complete, "volume");
  if (complete.contains("series")) scene.grid.series = complete["series"].get<std::string>();
  scene.grid.crease_deg = optional_number(complete, "crease");
  scene.width = complete["size"][0].get<int>();
  scene.height = complete["size"][1].get<int>();
  for_each_item(document, complete, "surface", [&](const json&, const json& item, const auto&) {
    scene.surfaces.push_back(describe_surface(item));
  });
  for_each_item(document, complete, "light",
                [&](const json& given, const json& item, const auto& at) {
                  scene.lights.push_back(describe_light(given, item, at));
                });
  if (complete.contains("ambient")) scene.ambient = color_of(complete["ambient"]);
  scene.camera = describe_camera(complete.contains("camera") ? complete["camera"] : json::object(),
                                 "--camera");
  if (complete["visibility"] == "raster") scene.visibility = Visibility::kRaster;
  scene.shadows = complete["shadows"] == "on";
  scene.mirror_depth = complete["mirror-depth"].get<int>();
  describe_indirect(document, complete, scene);
  scene.display.curve = complete["display"] == "raw" ? Display::Curve::kRaw : Display::Curve::kSrgb;
  scene.display.exposure = complete["exposure"].get<double>();
  scene.background = color_of(complete["background"]);
  return scene;
}

}  // namespace isolux
