#include <iostream>

#include "isolux/base/error.h"
#include "isolux/base/number_text.h"
#include "isolux/base/output_file.h"
#include "isolux/cli/command.h"
#include "isolux/cli/loaded_scene.h"
#include "isolux/cli/terminal.h"
#include "isolux/intersect/mesh_distance.h"
#include "isolux/io/write_mesh.h"
#include "isolux/mesh/extract_isosurface.h"
#include "isolux/mesh/mesh_topology.h"
#include "isolux/mesh/simplify_mesh.h"
#include "isolux/mesh/weld.h"
#include "isolux/scene/option_value.h"
#include "isolux/volume/statistics.h"

namespace isolux {
namespace {

template <typename Value>
std::optional<Value> value_of(const Command& command, const Arguments& arguments,
                              const std::string& name) {
  if (!arguments.has(name)) return std::nullopt;
  const Option& option = *find_option(command.options, name);
  return value_from_text(option, arguments.at(name), "--" + name).get<Value>();
}

double first_suggested_iso(const ReadResult& input) {
  const auto suggested = suggest_iso(*input.volume, value_statistics(*input.volume));
  if (suggested.empty()) {
    throw WorkError(input.name, "all its voxels have one value", "there is no surface in it");
  }
  std::cerr << "isolux: iso value " << to_text(suggested[0].value) << " (" << suggested[0].name
            << ")\n";
  return suggested[0].value;
}

Mesh mesh_of(const ReadResult& input, double iso) {
  Mesh mesh = extract_isosurface(*input.volume, iso);
  if (!mesh.triangles.empty()) return mesh;
  const ValueStatistics values = value_statistics(*input.volume);
  throw WorkError(input.name, "has no surface at iso value " + to_text(iso),
                  "its values run from " + to_text(values.min) + " to " + to_text(values.max));
}

std::string counted(std::size_t count, const std::string& what) {
  return std::to_string(count) + " " + what + (count == 1 ? "" : "s");
}

void tell_topology(const Mesh& mesh, const MeshTopology& topology) {
  std::cerr << "  " << counted(topology.triangles, "triangle") << ", " << mesh.positions.size()
            << " vertices, " << (topology.is_watertight() ? "watertight" : "not watertight")
            << "\n";
  if (topology.border_edges > 0) {
    std::cerr << "  it ends at " << counted(topology.border_edges, "edge") << "\n";
  }
  if (topology.crowded_edges > 0) {
    std::cerr << "  more than two triangles share " << counted(topology.crowded_edges, "edge")
              << "\n";
  }
  if (topology.inconsistent_edges > 0) {
    std::cerr << "  the triangles at " << counted(topology.inconsistent_edges, "edge")
              << " face to different sides\n";
  }
}

// What an extracted mesh is to the exact surface.
void tell_extraction(const Mesh& mesh, const ReadResult& input, double iso) {
  if (topology_of(mesh).border_edges > 0) {
    const bool has_gaps = value_statistics(*input.volume).not_finite > 0;
    std::cerr << "  the volume's border" << (has_gaps ? ", or voxels that are no number," : "")
              << " cut it\n";
  }
  const IsoSurface surface(input.volume, std::make_shared<const BrickGrid>(*input.volume), iso);
  const MeshDistance distance = distance_between(mesh, surface);
  std::cerr << "  from triangle centres to the exact isosurface: " << to_text9(distance.mean_mm)
            << " mm on average, " << to_text9(distance.greatest_mm) << " mm at the most\n";
}

}  // namespace

int run_mesh(const Command& command, const Arguments& arguments) {
  if (arguments.inputs.size() != 2) {
    throw UsageError("isolux mesh", "takes one INPUT and one OUT",
                     "such as `isolux mesh head.nrrd skull.stl --iso 300`");
  }
  const std::string output = arguments.inputs[1];
  const std::string space_name = value_of<std::string>(command, arguments, "space").value_or("lps");
  const MeshSpace space = space_name == "ras" ? MeshSpace::kRas : MeshSpace::kLps;
  check_mesh_name(output, space);
  check_writable(output);
  const auto share = value_of<double>(command, arguments, "decimate");
  const auto given_iso = value_of<double>(command, arguments, "iso");

  Arguments of_input = arguments;
  of_input.inputs.pop_back();
  const SceneDescription description = describe(document_from(of_input), "mesh");
  const ReadResult input = read_inputs(description, progress_bar(arguments)).front();
  tell_notes(input);
  if (input.mesh && given_iso) {
    throw UsageError("--iso", input.name + " is a mesh already", "leave it out");
  }
  double iso = 0;
  if (!input.mesh) iso = given_iso ? *given_iso : first_suggested_iso(input);
  Mesh mesh = input.mesh ? *input.mesh : mesh_of(input, iso);
  if (share) mesh = simplified(mesh, *share);
  write_mesh(output, mesh, space);
  std::cerr << "isolux: " << output << "\n";
  for (const std::string& loss : mesh_losses(output, mesh)) std::cerr << "  " << loss << "\n";
  tell_topology(mesh, topology_of(input.mesh ? welded_by_position(mesh) : mesh));
  if (!input.mesh) tell_extraction(mesh, input, iso);
  return 0;
}

}  // namespace isolux
