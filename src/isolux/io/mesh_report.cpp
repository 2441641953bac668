#include "isolux/io/mesh_report.h"

#include <nlohmann/json.hpp>

#include "isolux/mesh/mesh_box.h"
#include "isolux/mesh/mesh_topology.h"
#include "isolux/mesh/weld.h"

namespace isolux {
namespace {

using nlohmann::json;

json numbers(Vec3 v) { return {v.x, v.y, v.z}; }
json numbers(Rgb c) { return {c.r, c.g, c.b}; }

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

}  // namespace

json mesh_report(const ReadResult& input) {
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

}  // namespace isolux
