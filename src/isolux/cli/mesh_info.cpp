#include "isolux/cli/mesh_info.h"

#include <iostream>
#include <nlohmann/json.hpp>

#include "isolux/base/memory.h"
#include "isolux/base/number_text.h"
#include "isolux/io/mesh_report.h"
#include "isolux/mesh/mesh_box.h"

namespace isolux {
namespace {

using nlohmann::json;

std::string text_of(Vec3 v) { return to_text9(v.x) + ", " + to_text9(v.y) + ", " + to_text9(v.z); }
std::string text_of(Rgb c) { return to_text9(c.r) + ":" + to_text9(c.g) + ":" + to_text9(c.b); }

void print_text(const ReadResult& input, const json& report) {
  const Mesh& mesh = *input.mesh;
  const MeshBox box = box_of(mesh);
  std::cout << input.name << ": " << input.format << ", a mesh\n"
            << "  triangles  " << mesh.triangles.size() << ", " << mesh.positions.size()
            << " vertices, " << bytes_text(report["bytes"].get<double>()) << "\n"
            << "  from       " << text_of(box.low) << " mm (LPS)\n"
            << "  to         " << text_of(box.high) << " mm\n"
            << "  vertices   with " << (mesh.normals.empty() ? "no normals" : "normals")
            << (mesh.colors.empty() ? "" : ", colours")
            << (mesh.texture_points.empty() ? "" : ", texture points") << "\n"
            << "  closed     " << (report["watertight"].get<bool>() ? "yes, watertight" : "no");
  if (const auto edges = report["border_edges"].get<std::size_t>(); edges > 0) {
    std::cout << ": ends at " << edges << " edges";
  }
  std::cout << "\n";
  for (const MeshMaterial& material : mesh.materials) {
    const Material& m = material.material;
    std::cout << "  material   " << (material.name.empty() ? "(no name)" : material.name)
              << ": ka=" << text_of(m.ka) << ",kd=" << text_of(m.kd) << ",ks=" << text_of(m.ks)
              << ",shininess=" << to_text9(m.shininess);
    if (material.base_color) {
      std::cout << ", texture " << material.base_color->width << "x" << material.base_color->height;
    }
    std::cout << "\n";
  }
  for (const std::string& note : input.notes) std::cout << "  note       " << note << "\n";
}

}  // namespace

void print_mesh_info(const ReadResult& input, bool as_json) {
  const json report = mesh_report(input);
  if (!as_json) return print_text(input, report);
  std::cout << report.dump(2, ' ', false, json::error_handler_t::replace) << "\n";
}

}  // namespace isolux
