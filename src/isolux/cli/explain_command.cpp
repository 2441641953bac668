#include <iostream>
#include <nlohmann/json.hpp>

#include "isolux/base/error.h"
#include "isolux/base/number_text.h"
#include "isolux/cli/command.h"
#include "isolux/cli/explain_text.h"
#include "isolux/cli/loaded_scene.h"
#include "isolux/render/explanation_json.h"
#include "isolux/render/pictures.h"

namespace isolux {
namespace {

struct Pixel {
  int x;
  int y;
};

Pixel parse_pixel(const Arguments& arguments) {
  if (!arguments.has("pixel")) {
    throw UsageError("--pixel", "is missing", "say which pixel, such as --pixel 512,400");
  }
  const std::string& text = arguments.at("pixel");
  const std::size_t comma = text.find(',');
  const auto x = parse_whole_number(text.substr(0, comma));
  const auto y =
      comma == std::string::npos ? std::nullopt : parse_whole_number(text.substr(comma + 1));
  if (!x || !y || *x < 0 || *y < 0 || *x > 1 << 20 || *y > 1 << 20) {
    throw UsageError("--pixel", "'" + text + "' is no pixel",
                     "give X,Y, counted from 0 at the top left");
  }
  return {static_cast<int>(*x), static_cast<int>(*y)};
}

}  // namespace

int run_explain(const Command&, const Arguments& arguments) {
  const Pixel pixel = parse_pixel(arguments);
  const LoadedScene loaded = load_scene(arguments);
  const Scene& scene = loaded.scene;
  if (pixel.x >= scene.camera->width() || pixel.y >= scene.camera->height()) {
    throw UsageError("--pixel", arguments.at("pixel") + " lies outside the picture",
                     "it has " + std::to_string(scene.camera->width()) + " x " +
                         std::to_string(scene.camera->height()) + " pixels, counted from 0");
  }
  if (scene.denoise) check_picture_memory(loaded.description, false);  // it takes all pixels
  const Explanation explanation = explain(scene, pixel.x, pixel.y);
  if (arguments.has("json")) {
    std::cout << explain_json(explanation).dump(2) << "\n";
    return 0;
  }
  std::vector<std::string> names;
  for (const SurfaceItem& item : scene.surfaces) {
    const std::string& name = loaded.description.inputs[item.input];
    names.push_back(item.mesh ? "the mesh " + name
                              : "the isosurface of " + name + " at " + to_text(item.iso));
  }
  std::cout << explain_text(scene, explanation, names);
  return 0;
}

}  // namespace isolux
