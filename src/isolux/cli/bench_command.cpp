#include <algorithm>
#include <array>
#include <iostream>
#include <nlohmann/json.hpp>
#include <string_view>
#include <thread>

#include "isolux/base/error.h"
#include "isolux/bench/as_peer.h"
#include "isolux/bench/mesh_works.h"
#include "isolux/bench/peer_contest.h"
#include "isolux/bench/scene_works.h"
#include "isolux/bench/table.h"
#include "isolux/bench/timing.h"
#include "isolux/cli/command.h"
#include "isolux/cli/loaded_scene.h"
#include "isolux/cli/terminal.h"
#include "isolux/scene/option_value.h"

namespace isolux {
namespace {

int threads_used(const Arguments& arguments) {
  const int asked = thread_count(arguments);
  return asked > 0 ? asked : static_cast<int>(std::thread::hardware_concurrency());
}

int turns_asked(const Command& command, const Arguments& arguments) {
  const Option& option = *find_option(command.options, "frames");
  const std::string text = arguments.has("frames") ? arguments.at("frames") : option.default_text;
  return value_from_text(option, text, "--frames").get<int>();
}

std::vector<Section> measured_scene(const LoadedScene& loaded, int turns) {
  Section section{loaded.inputs[0].name, {}};
  const auto add = [&](const std::vector<Work>& works) {
    for (const Work& work : works) section.measurements.push_back(measure(work));
  };
  const SurfaceItem& first = loaded.scene.surfaces[0];
  if (!first.mesh) {
    OwnRenderer renderer(loaded.scene);
    renderer.prepare();
    renderer.frame();
    add(scene_works(renderer, turns));
    add({extraction_work(renderer, turns)});
  }
  const auto mesh = first.mesh ? first.mesh : extracted_mesh(loaded.scene);
  if (mesh->triangles.empty()) return {section};
  MeshRenderers on_triangles(first.mesh ? loaded.scene : on_mesh(loaded.scene, mesh));
  add(mesh_works(on_triangles, turns));
  return {section};
}

// What is drawn beside the peers is fixed, so that the figures of two runs can be compared.
void refuse_own_scene(const Arguments& arguments) {
  constexpr std::array<std::string_view, 7> kOfInputs{"size",   "dims",   "type",  "spacing",
                                                      "volume", "series", "crease"};
  for (const auto& [name, values] : arguments.values) {
    const bool is_of_scene = name == "scene" || find_option(scene_options(), name);
    if (is_of_scene && std::ranges::find(kOfInputs, name) == kOfInputs.end()) {
      throw UsageError("--" + name, "does not go with --peers",
                       "surfaces, lights and views are those of bench/README.md");
    }
  }
  if (arguments.inputs.size() > 1) {
    throw UsageError(arguments.inputs[1], "--peers takes one INPUT", "leave it out");
  }
}

std::vector<Section> measured_with_peers(const LoadedScene& loaded, const Command& command,
                                         const Arguments& arguments, int turns) {
  ContestOptions options;
  options.peers_folder = arguments.has("peers-in")
                             ? arguments.at("peers-in")
                             : find_option(command.options, "peers-in")->default_text;
  if (arguments.has("against")) options.other_isolux = arguments.at("against");
  if (arguments.has("pictures")) options.pictures_folder = arguments.at("pictures");
  for (const char* name : {"threads", "isa"}) {
    if (!arguments.has(name)) continue;
    options.own_options.insert(options.own_options.end(),
                               {std::string("--") + name, arguments.at(name)});
  }
  options.threads = threads_used(arguments);
  options.turns = turns;
  options.width = loaded.scene.camera->width();
  options.height = loaded.scene.camera->height();
  options.tell = [](const std::string& text) { std::cerr << "isolux: " << text << "\n"; };
  const ReadResult& input = loaded.inputs[0];
  return input.mesh ? measure_mesh_against_peers(*input.mesh, input.name, options)
                    : measure_against_peers(*input.volume, options);
}

}  // namespace

int run_bench(const Command& command, const Arguments& arguments) {
  if (arguments.has("as-peer")) {
    answer_as_peer(arguments.at("as-peer"));
    return 0;
  }
  const int turns = turns_asked(command, arguments);
  if (arguments.has("peers")) refuse_own_scene(arguments);
  const LoadedScene loaded = load_scene(arguments);
  const Camera& camera = *loaded.scene.camera;
  Report report{camera.width(),
                camera.height(),
                threads_used(arguments),
                processor_name(),
                load_average(),
                -1,
                {}};
  report.sections = arguments.has("peers") ? measured_with_peers(loaded, command, arguments, turns)
                                           : measured_scene(loaded, turns);
  report.load_after = load_average();
  std::cout << (arguments.has("json") ? report_json(report).dump(2) + "\n" : report_text(report));
  return 0;
}

}  // namespace isolux
