#include "isolux/cli/command.h"

#include <CLI/CLI.hpp>
#include <nlohmann/json.hpp>

#include "isolux/base/error.h"
#include "isolux/base/instruction_set.h"
#include "isolux/base/memory.h"
#include "isolux/base/number_text.h"
#include "isolux/io/data_file.h"
#include "isolux/scene/option_value.h"

namespace isolux {
namespace {

using enum ValueType;

const Option kThreads{.name = "threads",
                      .type = kWhole,
                      .sentence = "how many threads to use (default: all cores)",
                      .low = 1,
                      .high = 1024};
const Option kMaxMemory{.name = "max-memory",
                        .type = kText,
                        .sentence = "how much memory data may take: 8G, 500M, or 50%",
                        .default_text = "80%"};
const Option kTrust{
    .name = "trust",
    .type = kFlag,
    .sentence = "let a header name data files anywhere, not only beside or below it"};
const Option kIsa{.name = "isa",
                  .type = kChoice,
                  .sentence =
                      "hold the program to an instruction set (default: the best that the "
                      "machine has); from avx2 up the bytes are the same",
                  .choices = instruction_sets()};
const Option kProgress{.name = "progress",
                       .type = kFlag,
                       .sentence = "show progress even where standard error is no terminal"};
const Option kScene{.name = "scene",
                    .type = kText,
                    .sentence = "a scene file; options on the command line go before it"};
const Option kJson{.name = "json", .type = kFlag, .sentence = "print one JSON object"};

Option scene_option(const char* name) { return *find_option(scene_options(), name); }

std::vector<Command> make_commands() {
  return {
      {"render",
       "[INPUT...]",
       "draw a picture",
       {{.name = "output",
         .type = kText,
         .sentence = "the picture, OUT.png or OUT.exr (short: -o)"},
        kScene,
        {.name = "save-scene", .type = kText, .sentence = "write the scene to a file"},
        {.name = "again",
         .type = kText,
         .sentence = "make a PNG or EXR of isolux again from what it carries; INPUTs say where the "
                     "inputs lie now"},
        kThreads,
        kMaxMemory,
        kTrust,
        kIsa,
        kProgress},
       true,
       {{"isolux render -o head.png", "the example CT head, lit from the eye"},
        {"isolux render phantom:head --surface iso=-300,kd=1:0.79:0.6 "
         "--light point,at=-300:-400:300 -o skin.png",
         "one isosurface in skin colour under a point light"},
        {"isolux render phantom:head --light point,at=0:0:57,space=index -o lecture.png",
         "a light at voxel (0, 0, 57)"},
        {"isolux render phantom:head --camera view=left,projection=orthographic -o left.exr",
         "all layers, linear, for measuring"}},
       run_render},
      {"explain",
       "[INPUT...]",
       "say why a pixel has its colour, with every number",
       {{.name = "pixel",
         .type = kText,
         .sentence = "the pixel as X,Y, counted from 0 at the top left"},
        kJson,
        kScene,
        kThreads,
        kMaxMemory,
        kTrust,
        kIsa,
        kProgress},
       true,
       {{"isolux explain phantom:sphere --pixel 500,400", "the lecture's sums for one pixel"},
        {"isolux explain phantom:sphere --pixel 500,400 --json", "the same for a program"}},
       run_explain},
      {"info",
       "[INPUT]",
       "say what a file holds and how it was understood",
       {kJson,
        {.name = "header",
         .type = kFlag,
         .sentence = "only what the header tells, with the memory that the voxels would take"},
        scene_option("dims"),
        scene_option("type"),
        scene_option("spacing"),
        scene_option("volume"),
        scene_option("series"),
        kMaxMemory,
        kTrust,
        kProgress},
       false,
       {{"isolux info phantom:head", "size, place in space, values, iso values worth trying"},
        {"isolux info --header phantom:head,size=1024",
         "whether it would fit, without reading it"}},
       run_info},
      {"convert",
       "INPUT OUT.{nrrd,nii.gz,nii,mha}",
       "write a volume in another format, placed as it was",
       {{.name = "crop",
         .type = kText,
         .sentence = "only the block of voxels I0:J0:K0,I1:J1:K1, both corners included"},
        {.name = "resample",
         .type = kVector,
         .sentence = "trilinear samples at another distance between voxel centres, after --crop",
         .unit = "mm",
         .low = 0,
         .high = 1e9,
         .low_excluded = true},
        scene_option("dims"),
        scene_option("type"),
        scene_option("spacing"),
        scene_option("volume"),
        scene_option("series"),
        kMaxMemory,
        kTrust,
        kProgress},
       false,
       {{"isolux convert phantom:sphere sphere.nii.gz", "for programs that read NIfTI"},
        {"isolux convert phantom:head,size=64 face.nrrd --crop 0:0:0,63:31:63 --resample 2:2:2",
         "the front half, coarser"}},
       run_convert},
      {"mesh",
       "INPUT OUT.{stl,ply,obj,glb}",
       "write an isosurface as triangles, or a mesh in another format",
       {{.name = "iso",
         .type = kNumber,
         .sentence = "the iso value; without it, the first of those that `isolux info` suggests"},
        {.name = "space",
         .type = kChoice,
         .sentence = "the axes of the file; its tag SPACE= tells which",
         .default_text = "lps",
         .choices = {"lps", "ras"}},
        {.name = "decimate",
         .type = kNumber,
         .sentence = "keep about this share of the triangles",
         .default_text = "1",
         .low = 0,
         .high = 1,
         .low_excluded = true},
        scene_option("dims"),
        scene_option("type"),
        scene_option("spacing"),
        scene_option("volume"),
        scene_option("series"),
        scene_option("crease"),
        kThreads,
        kMaxMemory,
        kTrust,
        kProgress},
       false,
       {{"isolux mesh phantom:head skull.stl --iso 300", "for a 3D printer, or 3D Slicer"},
        {"isolux mesh phantom:head face.glb --iso -300 --decimate 0.1", "for the web"}},
       run_mesh},
      {"view",
       "[INPUT...]",
       "drag the lamp: see and change a scene in the browser",
       {{.name = "port",
         .type = kWhole,
         .sentence = "the port to listen on (default: 7411, or a free one)",
         .low = 1,
         .high = 65535},
        {.name = "host",
         .type = kText,
         .sentence = "the address to listen on; any but this machine's own loopback lets others "
                     "reach the viewer, without encryption",
         .default_text = "127.0.0.1"},
        {.name = "no-open", .type = kFlag, .sentence = "do not open the browser"},
        kScene,
        kThreads,
        kMaxMemory,
        kTrust,
        kIsa,
        kProgress},
       true,
       {{"isolux view", "the example CT head"},
        {"isolux view --no-open --port 8000",
         "on a server: then `ssh -L 8000:127.0.0.1:8000 SERVER` and open the URL at home"}},
       run_view},
      {"bench",
       "[INPUT...]",
       "time the parts of a frame, alone or against other programs",
       {{.name = "frames",
         .type = kWhole,
         .sentence = "how many frames to time; with --peers, how many degrees of the orbit",
         .default_text = "21",
         .low = 1,
         .high = 10000},
        {.name = "peers",
         .type = kFlag,
         .sentence = "measure against Embree and VTK on a CT head, frames interleaved "
                     "(bench/README.md)"},
        {.name = "peers-in",
         .type = kText,
         .sentence = "the folder where the peers were built",
         .default_text = "build/bench"},
        {.name = "against",
         .type = kText,
         .sentence = "with --peers, another build of isolux to take turns with as well"},
        {.name = "pictures",
         .type = kText,
         .sentence = "with --peers, a folder for the pictures that each side draws"},
        {.name = "as-peer",
         .type = kText,
         .sentence = "be a peer of that name: answer the requests of bench/README.md on standard "
                     "input"},
        kJson,
        kScene,
        kThreads,
        kMaxMemory,
        kTrust,
        kIsa},
       true,
       {{"isolux bench phantom:head --size 256x256 --frames 3", "medians over three frames"},
        {"isolux bench --peers --frames 360 --json", "a whole orbit against the peers"}},
       run_bench},
      {"manual", "", "print the manual page (docs/manual.md)", {}, false, {}, run_manual},
  };
}

// An option right behind another is not its value, though it could be taken for one.
void check_values_follow(const std::vector<Option>& options,
                         const std::vector<std::string>& arguments) {
  const auto option_of = [&](const std::string& argument) -> const Option* {
    if (argument == "-o") return find_option(options, "output");
    return argument.starts_with("--") ? find_option(options, argument.substr(2)) : nullptr;
  };
  for (std::size_t n = 0; n < arguments.size(); ++n) {
    const Option* option = option_of(arguments[n]);
    if (!option || option->type == kFlag) continue;
    if (n + 1 < arguments.size() && !option_of(arguments[n + 1])) {
      ++n;
      continue;
    }
    throw UsageError("--" + option->name, "is given without its value",
                     "see `isolux COMMAND --help` for what it takes");
  }
}

}  // namespace

const std::vector<Command>& commands() {
  static const std::vector<Command> list = make_commands();
  return list;
}

std::vector<Option> all_options(const Command& command) {
  std::vector<Option> options = command.options;
  if (command.takes_scene) {
    options.insert(options.end(), scene_options().begin(), scene_options().end());
  }
  return options;
}

Arguments parse(const Command& command, const std::vector<std::string>& arguments) {
  const std::vector<Option> options = all_options(command);
  check_values_follow(options, arguments);
  CLI::App app;
  app.set_help_flag();
  app.allow_extras();
  Arguments parsed;
  std::map<std::string, bool> flags;
  for (const Option& option : options) {
    const std::string flag = (option.name == "output" ? "-o,--" : "--") + option.name;
    if (option.type == kFlag) {
      app.add_flag(flag, flags[option.name]);
    } else {
      app.add_option(flag, parsed.values[option.name])->allow_extra_args(false);
    }
  }
  if (!command.inputs.empty()) app.add_option("INPUT", parsed.inputs);
  std::vector<std::string> reversed(arguments.rbegin(), arguments.rend());  // as CLI11 wants them
  try {
    app.parse(reversed);
  } catch (const CLI::ParseError& error) {
    throw UsageError("isolux " + command.name, error.what(),
                     "see `isolux " + command.name + " --help`");
  }
  for (const std::string& extra : app.remaining()) {
    const std::string name = extra.substr(0, extra.find('='));
    const std::string near =
        name.starts_with("--") ? nearest_name(options, name.substr(2)) : std::string();
    throw UsageError(
        extra, "`isolux " + command.name + "` does not take it",
        near.empty() ? "see `isolux " + command.name + " --help`" : "did you mean --" + near + "?");
  }
  for (const Option& option : options) {
    if (option.type == kFlag && flags[option.name]) parsed.values[option.name] = {"true"};
    if (parsed.values[option.name].empty()) {
      parsed.values.erase(option.name);
    } else if (!option.repeatable && parsed.values[option.name].size() > 1) {
      throw UsageError("--" + option.name, "is given twice", "give it once");
    }
  }
  return parsed;
}

void apply_policies(const Arguments& arguments) {
  if (arguments.has("trust")) trust_headers();
  if (arguments.has("isa")) {
    hold_to_instruction_set(value_from_text(kIsa, arguments.at("isa"), "--isa").get<std::string>());
  }
  if (!arguments.has("max-memory")) return;
  const auto bytes = parse_memory(arguments.at("max-memory"));
  if (!bytes) {
    throw UsageError("--max-memory", "'" + arguments.at("max-memory") + "' is no amount of memory",
                     "give 8G, 500M, or 50%");
  }
  set_memory_limit(*bytes);
}

int thread_count(const Arguments& arguments) {
  if (!arguments.has("threads")) return 0;
  const auto count = parse_whole_number(arguments.at("threads"));
  if (!count || static_cast<double>(*count) < kThreads.low ||
      static_cast<double>(*count) > kThreads.high) {
    throw UsageError("--threads", "'" + arguments.at("threads") + "' is no number of threads",
                     "give a whole number from 1 to 1024");
  }
  return static_cast<int>(*count);
}

}  // namespace isolux
