#include "isolux/cli/loaded_scene.h"

#include <filesystem>
#include <fstream>
#include <iterator>

#include "isolux/base/error.h"
#include "isolux/cli/terminal.h"
#include "isolux/scene/document.h"
#include "isolux/scene/option_value.h"

namespace isolux {
namespace {

using nlohmann::json;

json read_scene_file(const std::string& path) {
  std::ifstream file(path);
  if (std::error_code none; std::filesystem::is_directory(path, none)) {
    throw WorkError(path, "is a folder", "give a scene file");
  }
  if (!file)
    throw WorkError(path, "there is no such scene file, or it cannot be read", "check the name");
  const json document = parse_document(
      {std::istreambuf_iterator<char>(file), std::istreambuf_iterator<char>()}, path);
  check_document(document, path);
  return document;
}

bool is_utf8(const std::string& text) {
  try {
    json(text).dump();
    return true;
  } catch (const json::type_error&) {
    return false;
  }
}

std::vector<std::shared_ptr<const Volume>> volumes_of(const std::vector<ReadResult>& inputs) {
  std::vector<std::shared_ptr<const Volume>> volumes;
  volumes.reserve(inputs.size());
  for (const ReadResult& input : inputs) volumes.push_back(input.volume);
  return volumes;
}

}  // namespace

json document_from(const Arguments& arguments) {
  json document =
      arguments.has("scene") ? read_scene_file(arguments.at("scene")) : empty_document();
  if (!arguments.inputs.empty()) document["input"] = arguments.inputs;
  for (const std::string& name : arguments.inputs) {
    // A scene, and so a picture's record, is JSON, which holds UTF-8 alone.
    if (!is_utf8(name)) throw UsageError(name, "its name is not UTF-8", "rename it");
  }
  for (const Option& option : scene_options()) {
    if (!arguments.has(option.name)) continue;
    json values = json::array();
    for (const std::string& text : arguments.values.at(option.name)) {
      values.push_back(value_from_text(option, text, "--" + option.name));
    }
    document[option.name] = option.repeatable ? values : values[0];
  }
  return document;
}

LoadedScene load_scene(const json& document, const std::string& what,
                       const std::vector<std::string>& paths, const ProgressListener& listener) {
  LoadedScene loaded{document, describe(document, what), {}, {}};
  SceneDescription& description = loaded.description;
  if (description.inputs.empty()) description.inputs = {kExampleHead};
  if (!paths.empty() && paths.size() != description.inputs.size()) {
    throw UsageError(what, "its scene has " + std::to_string(description.inputs.size()) + " inputs",
                     "name as many, in its order, or none");
  }
  SceneDescription at_paths = description;
  if (!paths.empty()) at_paths.inputs = paths;
  loaded.inputs = read_inputs(at_paths, listener);
  for (std::size_t n = 0; n < loaded.inputs.size(); ++n) {
    tell_notes(loaded.inputs[n]);
    if (paths.empty()) description.inputs[n] = loaded.inputs[n].name;
  }
  loaded.document["input"] = description.inputs;
  loaded.scene = resolve(description, volumes_of(loaded.inputs));
  return loaded;
}

LoadedScene load_scene(const Arguments& arguments) {
  return load_scene(document_from(arguments), "scene", {}, progress_bar(arguments));
}

}  // namespace isolux
