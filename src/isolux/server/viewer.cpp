#include "isolux/server/viewer.h"

#include <cmath>
#include <filesystem>
#include <utility>

#include "isolux/base/error.h"
#include "isolux/render/pictures.h"
#include "isolux/render/session.h"
#include "isolux/scene/document.h"
#include "isolux/scene/option_table.h"
#include "isolux/volume/statistics.h"

namespace isolux {
namespace {

using nlohmann::json;

// Two draw at a time, so that one page's slow frame does not hold up all others.
constexpr int kDrawingThreads = 2;

// The scene options that this version honours; a page shows controls for these alone.
json honoured_options() {
  json names = json::array();
  for (const Option& option : scene_options()) {
    if (option.not_yet.empty()) names.push_back(option.name);
    for (const Option& field : option.fields) {
      if (field.not_yet.empty()) names.push_back(option.name + "." + field.name);
    }
  }
  return names;
}

// A scene to begin with: every default written out, the surface that would be drawn without any,
// and, where no light was asked for, a lamp that can be seen and dragged: before the face, above it
// and to its right.
json starting_scene(const json& document, const std::vector<SceneInput>& inputs) {
  json scene = with_defaults(document);
  if (!scene.contains("surface")) {
    scene["surface"] = json::array();
    for (std::size_t n = 0; n < inputs.size(); ++n) {
      const auto suggested = suggest_iso(*inputs[n].volume, value_statistics(*inputs[n].volume));
      if (suggested.empty()) continue;
      scene["surface"].push_back({{"iso", suggested[0].value}});
      if (inputs.size() > 1) scene["surface"].back()["input"] = n + 1;
    }
  }
  if (!scene.contains("light")) {
    const BoundingSphere sphere = bounding_sphere(inputs);
    const Vec3 at = sphere.center + sphere.radius_mm * Vec3{-0.45, -0.8, 0.5};
    scene["light"] = {
        {{"kind", "point"}, {"at", {std::round(at.x), std::round(at.y), std::round(at.z)}}}};
  }
  return with_defaults(scene);
}

json bounds_json(const std::vector<SceneInput>& inputs) {
  const BoundingSphere sphere = bounding_sphere(inputs);
  return {{"center", {sphere.center.x, sphere.center.y, sphere.center.z}},
          {"radius", sphere.radius_mm}};
}

std::string text_of(const json& message) {
  return message.dump(-1, ' ', false, json::error_handler_t::replace);
}

std::string without(const std::string& folder, std::string text) {
  for (std::size_t at = 0; (at = text.find(folder)) != std::string::npos;) {
    text.erase(at, folder.size());
  }
  return text;
}

}  // namespace

Viewer::Viewer(std::string version, const json& document, std::vector<ReadResult> inputs)
    : version_(std::move(version)), drawing_(kDrawingThreads), long_work_(1) {
  for (ReadResult& input : inputs) inputs_.add(std::move(input), reading_keys(document), false);
  const auto named = inputs_.inputs_of(document);
  document_ = starting_scene(document, named);
  bounds_ = bounds_json(named);
}

std::shared_ptr<Client> Viewer::connect(const std::shared_ptr<Outlet>& outlet) {
  outlet->send_text(text_of({{"type", "hello"},
                             {"version", version_},
                             {"scene", document_},
                             {"bounds", bounds_},
                             {"inputs", inputs_.reports()},
                             {"options", honoured_options()}}));
  return std::make_shared<Client>(inputs_, drawing_, outlet);
}

void Viewer::finish() {
  drawing_.finish();
  long_work_.finish();
}

std::string Viewer::saved_picture(const json& request) const {
  if (!request.is_object() || request.size() != 2 || !request.contains("scene") ||
      !request.contains("format") || (request["format"] != "png" && request["format"] != "exr")) {
    throw UsageError("save", "wants a scene, and png or exr", "reload the page");
  }
  const json& document = request["scene"];
  const SceneDescription description = describe(document, "scene");
  const bool is_exr = request["format"] == "exr";
  check_picture_memory(description, is_exr);
  const Scene scene = resolve(description, inputs_.inputs_of(document));
  Session session;
  const SurfaceBuffer& surfaces = session.surfaces(scene);
  return encode_picture(
      scene, surfaces, session.shadows(scene), session.indirect(scene),
      provenance(version_, with_defaults(document), inputs_.checksums_of(document)), is_exr);
}

std::string Viewer::open_dropped(const std::string& path, const std::string& name) {
  const std::string folder = std::filesystem::path(path).parent_path().string() + "/";
  ReadResult input;
  try {
    input = read_input({path, {}, {}});
  } catch (const Error& error) {
    // It names a file in a folder that is gone when the message is read.
    const std::string why = without(folder, error.what());
    const std::size_t colon = why.find(": "), hint = why.rfind("; ");
    throw WorkError(why.substr(0, colon), why.substr(colon + 2, hint - colon - 2),
                    why.substr(hint + 2));
  }
  input.name = name;
  for (std::string& note : input.notes) note = without(folder, note);
  const std::string opened = inputs_.add(std::move(input), json::object(), true);
  json document = empty_document();
  document["input"] = {opened};
  const auto named = inputs_.inputs_of(document);
  return text_of({{"scene", starting_scene(document, named)},
                  {"bounds", bounds_json(named)},
                  {"inputs", inputs_.reports()}});
}

}  // namespace isolux
