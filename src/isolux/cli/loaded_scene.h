#pragma once

#include <nlohmann/json.hpp>
#include <vector>

#include "isolux/cli/command.h"
#include "isolux/io/reader.h"
#include "isolux/scene/scene.h"

namespace isolux {

/// The scene document that the arguments say: the file of --scene, if any, with the command line's
/// own options and inputs in place of the file's.
nlohmann::json document_from(const Arguments& arguments);

/// A scene with its inputs read.
struct LoadedScene {
  nlohmann::json document;  ///< with the inputs as they can be named again
  SceneDescription description;
  std::vector<ReadResult> inputs;
  Scene scene;
};

/// Reads the inputs of a document (from `paths` instead of the names it gives, where not empty) and
/// puts the scene together. Tells notes on standard error.
/// @param what  where the document came from, for errors.
LoadedScene load_scene(const nlohmann::json& document, const std::string& what,
                       const std::vector<std::string>& paths, const ProgressListener& listener);

/// document_from and load_scene at once.
LoadedScene load_scene(const Arguments& arguments);

}  // namespace isolux
