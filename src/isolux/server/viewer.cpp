#include "isolux/server/viewer.h"

#include <filesystem>
#include <optional>
#include <utility>

#include "isolux/base/error.h"
#include "isolux/io/unpacked_archive.h"
#include "isolux/render/pictures.h"
#include "isolux/render/session.h"
#include "isolux/render/shown_layer.h"
#include "isolux/scene/document.h"
#include "isolux/scene/option_table.h"
#include "isolux/scene/option_value.h"
#include "isolux/server/starting_scene.h"

namespace isolux {
namespace {

using nlohmann::json;

// Two pages' pictures at a time; those that take long step aside, and others go on beside them.
constexpr int kDrawnAtOnce = 2, kDrawnAside = 14;

json option_json(const Option& option) {
  json row = {{"sentence", option.sentence},
              {"unit", option.unit},
              {"choices", option.choices},
              {"low", option.low},
              {"high", option.high}};
  if (!option.default_text.empty()) {
    row["default"] = value_from_text(option, option.default_text, option.name);
  }
  return row;
}

// The scene options that this version honours, by name; a page shows controls for these alone.
json honoured_options() {
  json rows = json::object();
  for (const Option& option : scene_options()) {
    if (option.not_yet.empty()) rows[option.name] = option_json(option);
    for (const Option& field : option.fields) {
      if (field.not_yet.empty()) rows[option.name + "." + field.name] = option_json(field);
    }
  }
  return rows;
}

json layer_names() {
  json names = json::array();
  for (const auto& [name, layer] : shown_layers()) names.push_back(name);
  return names;
}

json bounds_json(const std::vector<SceneInput>& inputs) {
  const BoundingSphere sphere = bounding_sphere(inputs);
  return {{"center", {sphere.center.x, sphere.center.y, sphere.center.z}},
          {"radius", sphere.radius_mm}};
}

std::string text_of(const json& message) {
  return message.dump(-1, ' ', false, json::error_handler_t::replace);
}

std::string folder_of(const std::string& path) {
  return std::filesystem::path(path).parent_path().string();
}

// Paths in folders that are gone when the text is read, as the page knows what lay there.
std::string replaced(const std::vector<std::pair<std::string, std::string>>& paths,
                     std::string text) {
  for (const auto& [path, known] : paths) {
    for (std::size_t at = 0; (at = text.find(path, at)) != std::string::npos; at += known.size()) {
      text.replace(at, path.size(), known);
    }
  }
  return text;
}

}  // namespace

Viewer::Viewer(std::string version, const json& document, std::vector<ReadResult> inputs)
    : version_(std::move(version)), drawing_(kDrawnAtOnce, kDrawnAside) {
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
                             {"options", honoured_options()},
                             {"layers", layer_names()}}));
  return std::make_shared<Client>(inputs_, drawing_, outlet);
}

void Viewer::finish() {
  drawing_.finish();
  long_work_.finish();
}

std::string Viewer::saved_picture(const json& request, const ProgressListener& listener) const {
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
  const SurfaceBuffer& buffer = session.surfaces(scene, listener);
  session.indirect(scene, listener);
  listener("lighting and writing", 1);
  return encode_picture(
      scene, buffer, session.shadows(scene), session.indirect(scene),
      provenance(version_, with_defaults(document), inputs_.checksums_of(document)), is_exr);
}

std::string Viewer::open_dropped(const DroppedFile& file, const ProgressListener& listener) {
  std::string path = file.path;
  std::vector<std::pair<std::string, std::string>> as_page_knows = {{folder_of(path) + "/", ""}};
  std::optional<UnpackedArchive> unpacked;  // goes when the checksums of what is in it are known
  ReadResult input;
  try {
    if (file.is_packed) {
      unpacked.emplace(path);
      path = unpacked->folder().string();
      as_page_knows.insert(as_page_knows.end(), {{path + "/", ""}, {path, file.name}});
    }
    input = read_input({path, {}, listener});
  } catch (const Error& error) {
    throw WorkError(replaced(as_page_knows, error.what()));
  }
  input.name = file.name;
  for (std::string& note : input.notes) note = replaced(as_page_knows, note);
  listener("looking", 1);  // from here on it is open, whoever has left
  const std::string opened = inputs_.add(std::move(input), json::object(), true);
  json document = empty_document();
  document["input"] = {opened};
  const auto named = inputs_.inputs_of(document);
  return text_of({{"scene", starting_scene(document, named)},
                  {"bounds", bounds_json(named)},
                  {"inputs", inputs_.reports()}});
}

}  // namespace isolux
