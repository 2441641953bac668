#include <algorithm>
#include <filesystem>
#include <future>
#include <set>

#include "isolux/base/error.h"
#include "isolux/base/number_text.h"
#include "isolux/base/output_file.h"
#include "isolux/cli/command.h"
#include "isolux/cli/loaded_scene.h"
#include "isolux/cli/terminal.h"
#include "isolux/io/provenance.h"
#include "isolux/render/indirect_light.h"
#include "isolux/render/pictures.h"
#include "isolux/render/ray_caster.h"
#include "isolux/scene/document.h"
#include "isolux/volume/statistics.h"

namespace isolux {
namespace {

bool wants_exr(const std::string& path) {
  if (path.ends_with(".exr")) return true;
  if (path.ends_with(".png")) return false;
  throw UsageError(path, "is neither .png nor .exr", "name the output OUT.png or OUT.exr");
}

void warn_about_unseen(const LoadedScene& loaded, const SurfaceBuffer& buffer) {
  std::set<std::int32_t> seen;
  for (std::size_t place = 0; place < buffer.pixels(); ++place) {
    if (buffer.is_hit(place)) seen.insert(buffer.surface[place]);
  }
  for (const FurtherPoints& points : buffer.further) {
    for (const FurtherPoint& point : points) seen.insert(point.surface);
  }
  for (std::size_t n = 0; n < loaded.scene.surfaces.size(); ++n) {
    if (seen.contains(static_cast<std::int32_t>(n))) continue;
    const SurfaceItem& item = loaded.scene.surfaces[n];
    std::string text = "surface " + std::to_string(n) + " is not in the picture";
    if (item.mesh) {
      warn(text);
      continue;
    }
    const ValueStatistics values = value_statistics(*item.volume);
    if (item.iso < values.min || item.iso > values.max) {
      text += ": the values of " + loaded.description.inputs[item.input] + " go from " +
              to_text(values.min) + " to " + to_text(values.max) + ", and iso is " +
              to_text(item.iso);
    }
    warn(text);
  }
}

std::vector<InputChecksums> all_checksums(const std::vector<ReadResult>& inputs,
                                          const std::vector<std::string>& names) {
  std::vector<InputChecksums> checksums;
  for (std::size_t n = 0; n < inputs.size(); ++n) {
    checksums.push_back(checksums_of(inputs[n]));
    checksums.back().input = names[n];
  }
  return checksums;
}

Indirect indirect_light(const Scene& scene, const RayCaster& caster, const SurfaceBuffer& buffer,
                        const Arguments& arguments) {
  if (scene.indirect == IndirectMethod::kOff) return {};
  IndirectLight light;
  Indirect found = light.find(scene, caster.surfaces(), buffer, progress_bar(arguments));
  tell("indirect light: " + light.told());
  return found;
}

// Draws and writes. `expected`: the checksums that the inputs must have, where a picture is made
// again.
void render_to(const LoadedScene& loaded, const std::string& output, const Arguments& arguments,
               const std::vector<InputChecksums>* expected) {
  auto checksums = std::async(
      std::launch::async, [&] { return all_checksums(loaded.inputs, loaded.description.inputs); });
  const Scene& scene = loaded.scene;
  const RayCaster caster(scene);
  const SurfaceBuffer buffer = caster.cast(*scene.camera, progress_bar(arguments));
  warn_about_unseen(loaded, buffer);
  Shadows shadows;
  cast_shadows(scene, caster.surfaces(), buffer, shadows, progress_bar(arguments));
  const Indirect indirect = indirect_light(scene, caster, buffer, arguments);

  const std::vector<InputChecksums> found = checksums.get();
  for (std::size_t n = 0; expected && n < found.size(); ++n) {
    // Of built-in volumes, which have no files, the name says all.
    const bool is_built_in = loaded.inputs[n].files.empty();
    if (n < expected->size() && (*expected)[n].sha256 == found[n].sha256 &&
        (!is_built_in || loaded.inputs[n].name == found[n].input)) {
      continue;
    }
    throw WorkError(found[n].input, "is not the file that the picture was made from",
                    "give the original, or render without --again");
  }
  const Metadata metadata = provenance(ISOLUX_VERSION, with_defaults(loaded.document), found);
  write_whole_file(output,
                   encode_picture(scene, buffer, shadows, indirect, metadata, wants_exr(output)));
}

int render_again(const Arguments& arguments, const std::string& output) {
  for (const auto& [name, values] : arguments.values) {
    if (name == "again" || name == "output" || name == "threads" || name == "isa" ||
        name == "progress" || name == "max-memory" || name == "trust") {
      continue;
    }
    throw UsageError("--" + name, "does not go with --again", "a picture carries its own scene");
  }
  const std::string& picture = arguments.at("again");
  const Provenance made = read_provenance(picture);
  const nlohmann::json document = nlohmann::json::parse(made.scene, nullptr, false);
  if (document.is_discarded()) {
    throw WorkError(picture, "the scene in it is damaged", "was the file edited?");
  }
  if (made.version != ISOLUX_VERSION) {
    warn(picture + " was made by isolux " + made.version + ", this is " + ISOLUX_VERSION +
         ": the bytes may differ");
  }
  const LoadedScene loaded =
      load_scene(document, picture, arguments.inputs, progress_bar(arguments));
  check_picture_memory(loaded.description, wants_exr(output));
  render_to(loaded, output, arguments, &made.inputs);
  return 0;
}

}  // namespace

int run_render(const Command&, const Arguments& arguments) {
  const bool saves_scene = arguments.has("save-scene");
  if (!arguments.has("output") && !saves_scene) {
    throw UsageError("--output", "is missing", "say where the picture goes, such as -o head.png");
  }
  const std::string output = arguments.has("output") ? arguments.at("output") : "";
  if (arguments.has("output")) {
    wants_exr(output);
    check_writable(output);
  }
  if (saves_scene) {
    check_writable(arguments.at("save-scene"));
    if (std::filesystem::weakly_canonical(arguments.at("save-scene")) ==
        std::filesystem::weakly_canonical(output)) {
      throw UsageError("--save-scene", "names the same file as --output", "give another name");
    }
  }
  if (arguments.has("again")) return render_again(arguments, output);

  const nlohmann::json document = document_from(arguments);
  const SceneDescription description = describe(document, "scene");
  if (arguments.has("output")) {
    check_picture_memory(description, wants_exr(output));
    const LoadedScene loaded = load_scene(document, "scene", {}, progress_bar(arguments));
    render_to(loaded, output, arguments, nullptr);
  }
  if (saves_scene) {
    write_whole_file(arguments.at("save-scene"), with_defaults(document).dump(2) + "\n");
  }
  return 0;
}

}  // namespace isolux
