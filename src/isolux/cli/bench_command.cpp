#include <algorithm>
#include <chrono>
#include <cstdio>
#include <functional>
#include <iostream>
#include <nlohmann/json.hpp>
#include <optional>

#include "isolux/cli/command.h"
#include "isolux/cli/loaded_scene.h"
#include "isolux/render/ray_caster.h"
#include "isolux/render/relight.h"
#include "isolux/scene/option_value.h"

namespace isolux {
namespace {

struct Timing {
  std::string work;
  std::vector<double> ms;

  double median() const {
    std::vector<double> sorted = ms;
    std::ranges::sort(sorted);
    return sorted[sorted.size() / 2];
  }
};

double milliseconds(const std::function<void()>& work) {
  const auto begin = std::chrono::steady_clock::now();
  work();
  return std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - begin)
      .count();
}

}  // namespace

int run_bench(const Command& command, const Arguments& arguments) {
  const Option& frames_option = *find_option(command.options, "frames");
  const int frames =
      value_from_text(frames_option,
                      arguments.has("frames") ? arguments.at("frames") : frames_option.default_text,
                      "--frames")
          .get<int>();
  const LoadedScene loaded = load_scene(arguments);
  const Scene& scene = loaded.scene;
  Timing bricks{"bricks and skipping", {}}, tracing{"visibility", {}},
      lighting{"lighting and display", {}}, display{"display", {}};
  SurfaceBuffer buffer(scene.camera->width(), scene.camera->height());
  LitPicture picture;
  for (int frame = 0; frame < frames; ++frame) {
    std::optional<RayCaster> caster;
    bricks.ms.push_back(milliseconds([&] { caster.emplace(scene); }));
    tracing.ms.push_back(milliseconds([&] { caster->cast(*scene.camera, buffer); }));
    lighting.ms.push_back(milliseconds([&] { picture.relight(scene, buffer); }));
    display.ms.push_back(milliseconds([&] { picture.redisplay(scene, buffer); }));
  }
  nlohmann::json rows = nlohmann::json::array();
  if (!arguments.has("json")) std::printf("%-20s %12s %12s\n", "work", "median ms", "least ms");
  for (const Timing& timing : {bricks, tracing, lighting, display}) {
    const double least = *std::ranges::min_element(timing.ms);
    rows.push_back({{"work", timing.work}, {"median_ms", timing.median()}, {"min_ms", least}});
    if (!arguments.has("json")) {
      std::printf("%-20s %12.2f %12.2f\n", timing.work.c_str(), timing.median(), least);
    }
  }
  if (arguments.has("json")) {
    std::cout << nlohmann::json{{"frames", frames},
                                {"width", scene.camera->width()},
                                {"height", scene.camera->height()},
                                {"rows", rows}}
                     .dump(2)
              << "\n";
  }
  std::fflush(stdout);
  return 0;
}

}  // namespace isolux
