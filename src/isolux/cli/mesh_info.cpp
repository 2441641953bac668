#include "isolux/cli/mesh_info.h"

#include <iostream>
#include <nlohmann/json.hpp>

#include "isolux/base/memory.h"
#include "isolux/base/number_text.h"
#include "isolux/mesh/mesh_box.h"
#include "isolux/mesh/mesh_topology.h"
#include "isolux/mesh/weld.h"

namespace isolux {
namespace {

using nlohmann::json;

json numbers(Vec3 v) { return {v.x, v.y, v.z}; }
json numbers(Rgb c) { return {c.r, c.g, c.b}; }
std::string text_of(Vec3 v) { return to_text9(v.x) + ", " + to_text9(v.y) + ", " + to_text9(v.z); }
std::string text_of(Rgb c) { return to_text9(c.r) + ":" + to_text9(c.g) + ":" + to_text9(c.b); }

double bytes_of(const Mesh& mesh) {
  const auto bytes = [](const auto& values) {
    return static_cast<double>(values.size() * sizeof(values[0]));
  };
  return bytes(mesh.positions) + bytes(mesh.normals) + bytes(mesh.texture_points) +
         bytes(mesh.colors) + bytes(mesh.triangles);
}

json materials_as_json(const Mesh& mesh) {
  json materials = json::array();
  for (const MeshMaterial& from : mesh.materials) {
    json material = {{"name", from.name},
                     {"ka", numbers(from.material.ka)},
                     {"kd", numbers(from.material.kd)},
                     {"ks", numbers(from.material.ks)},
                     {"shininess", from.material.shininess}};
    if (from.base_color) material["texture"] = {from.base_color->width, from.base_color->height};
    materials.push_back(material);
  }
  return materials;
}

json as_json_object(const ReadResult& input) {
  const Mesh& mesh = *input.mesh;
  const MeshTopology topology = topology_of(welded_by_position(mesh));
  const MeshBox box = box_of(mesh);
  return {{"kind", "mesh"},
          {"input", input.name},
          {"format", input.format},
          {"vertices", mesh.positions.size()},
          {"triangles", mesh.triangles.size()},
          {"box", {numbers(box.low), numbers(box.high)}},
          {"normals", !mesh.normals.empty()},
          {"colors", !mesh.colors.empty()},
          {"texture_points", !mesh.texture_points.empty()},
          {"watertight", topology.is_watertight()},
          {"border_edges", topology.border_edges},
          {"materials", materials_as_json(mesh)},
          {"bytes", bytes_of(mesh)},
          {"files", input.files},
          {"notes", input.notes}};
}

void print_text(const ReadResult& input) {
  const Mesh& mesh = *input.mesh;
  const MeshTopology topology = topology_of(welded_by_position(mesh));
  const MeshBox box = box_of(mesh);
  std::cout << input.name << ": " << input.format << ", a mesh\n"
            << "  triangles  " << mesh.triangles.size() << ", " << mesh.positions.size()
            << " vertices, " << bytes_text(bytes_of(mesh)) << "\n"
            << "  from       " << text_of(box.low) << " mm (LPS)\n"
            << "  to         " << text_of(box.high) << " mm\n"
            << "  vertices   with " << (mesh.normals.empty() ? "no normals" : "normals")
            << (mesh.colors.empty() ? "" : ", colours")
            << (mesh.texture_points.empty() ? "" : ", texture points") << "\n"
            << "  closed     " << (topology.is_watertight() ? "yes, watertight" : "no");
  if (topology.border_edges > 0) std::cout << ": ends at " << topology.border_edges << " edges";
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
  if (!as_json) return print_text(input);
  std::cout << as_json_object(input).dump(2, ' ', false, json::error_handler_t::replace) << "\n";
}

}  // namespace isolux
