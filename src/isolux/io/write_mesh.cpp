#include "isolux/io/write_mesh.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <cstring>

#include "isolux/base/error.h"
#include "isolux/base/output_file.h"
#include "isolux/image/display.h"
#include "isolux/io/mesh_encoders.h"

namespace isolux {
namespace {

// Turns a vector into the file's space and back: half a turn about z.
Vec3f carried(Vec3f v, MeshSpace space) {
  return space == MeshSpace::kRas ? Vec3f{-v.x, -v.y, v.z} : v;
}

const char* tag(MeshSpace space) { return space == MeshSpace::kRas ? "SPACE=RAS" : "SPACE=LPS"; }

template <typename T>
void append(std::string& bytes, const T& value) {
  bytes.append(reinterpret_cast<const char*>(&value), sizeof value);
}

void append_text(std::string& text, auto number) {
  char buffer[32];
  text.append(buffer, std::to_chars(buffer, buffer + sizeof buffer, number).ptr);
}

void append_line(std::string& text, const char* word, std::initializer_list<float> numbers) {
  text += word;
  for (const float number : numbers) {
    text += ' ';
    append_text(text, number);
  }
}

struct Encoding {
  const char* ending;
  std::string (*encode)(const Mesh&, MeshSpace);
};
constexpr std::array<Encoding, 4> kEncodings = {
    {{".stl", as_stl}, {".ply", as_ply}, {".obj", as_obj}, {".glb", as_glb}}};

const Encoding& encoding_for(const std::string& path) {
  for (const Encoding& encoding : kEncodings) {
    if (path.ends_with(encoding.ending)) return encoding;
  }
  throw UsageError(path, "is of no mesh format that is written here",
                   "name the output OUT.stl, OUT.ply, OUT.obj or OUT.glb");
}

}  // namespace

std::string as_stl(const Mesh& mesh, MeshSpace space) {
  std::string bytes = std::string("binary STL of isolux, mm, ") + tag(space);
  bytes.resize(80, ' ');
  append(bytes, static_cast<std::uint32_t>(mesh.triangles.size()));
  bytes.reserve(84 + 50 * mesh.triangles.size());
  for (const Mesh::Triangle& triangle : mesh.triangles) {
    const auto [a, b, c] = corners(mesh, triangle);
    const Vec3 normal = cross(b - a, c - a);
    append(bytes, carried(normal == Vec3{} ? Vec3f{} : as_float(normalize(normal)), space));
    for (const std::uint32_t vertex : triangle) {
      append(bytes, carried(mesh.positions[vertex], space));
    }
    append(bytes, std::uint16_t{0});
  }
  return bytes;
}

std::string as_ply(const Mesh& mesh, MeshSpace space) {
  const std::size_t vertices = mesh.positions.size();
  std::string bytes = "ply\nformat binary_little_endian 1.0\ncomment isolux, mm, ";
  bytes += std::string(tag(space)) + "\nelement vertex " + std::to_string(vertices) +
           "\nproperty float x\nproperty float y\nproperty float z\n";
  if (!mesh.normals.empty()) bytes += "property float nx\nproperty float ny\nproperty float nz\n";
  if (!mesh.texture_points.empty()) bytes += "property float s\nproperty float t\n";
  if (!mesh.colors.empty()) {
    bytes += "property uchar red\nproperty uchar green\nproperty uchar blue\n";
  }
  bytes += "element face " + std::to_string(mesh.triangles.size()) +
           "\nproperty list uchar int vertex_indices\nend_header\n";
  for (std::size_t v = 0; v < vertices; ++v) {
    append(bytes, carried(mesh.positions[v], space));
    if (!mesh.normals.empty()) append(bytes, carried(mesh.normals[v], space));
    if (!mesh.texture_points.empty()) append(bytes, mesh.texture_points[v]);
    if (!mesh.colors.empty()) {
      const Vec3f color = mesh.colors[v];
      append(bytes, displayed({}, {color.x, color.y, color.z}));
    }
  }
  for (const Mesh::Triangle& triangle : mesh.triangles) {
    append(bytes, std::uint8_t{3});
    append(bytes, triangle);
  }
  return bytes;
}

std::string as_obj(const Mesh& mesh, MeshSpace space) {
  std::string text = std::string("# isolux, mm, ") + tag(space) + "\n";
  for (std::size_t v = 0; v < mesh.positions.size(); ++v) {
    const Vec3f p = carried(mesh.positions[v], space);
    append_line(text, "v", {p.x, p.y, p.z});
    if (!mesh.colors.empty()) {
      const auto srgb = [](float c) { return static_cast<float>(transfer({}, c)); };
      const Vec3f color = mesh.colors[v];
      append_line(text, "", {srgb(color.x), srgb(color.y), srgb(color.z)});
    }
    text += '\n';
  }
  for (const TexturePoint& point : mesh.texture_points) {
    append_line(text, "vt", {point.u, point.v});
    text += '\n';
  }
  for (const Vec3f& normal : mesh.normals) {
    const Vec3f n = carried(normal, space);
    append_line(text, "vn", {n.x, n.y, n.z});
    text += '\n';
  }
  for (const Mesh::Triangle& triangle : mesh.triangles) {
    text += 'f';
    for (const std::uint32_t vertex : triangle) {
      text += ' ';
      append_text(text, vertex + std::uint64_t{1});
      if (!mesh.texture_points.empty() || !mesh.normals.empty()) text += '/';
      if (!mesh.texture_points.empty()) append_text(text, vertex + std::uint64_t{1});
      if (!mesh.normals.empty()) text += '/';
      if (!mesh.normals.empty()) append_text(text, vertex + std::uint64_t{1});
    }
    text += '\n';
  }
  return text;
}

std::vector<std::string> mesh_losses(const std::string& path, const Mesh& mesh) {
  std::vector<std::string> losses;
  if (path.ends_with(".glb")) return losses;
  const bool is_stl = path.ends_with(".stl");
  if (is_stl && !mesh.normals.empty()) losses.push_back("STL holds no normals of vertices");
  if (is_stl && !mesh.colors.empty()) losses.push_back("STL holds no colours");
  const auto has_texture = [](const MeshMaterial& m) { return m.base_color != nullptr; };
  if (mesh.materials.size() > 1 || std::ranges::any_of(mesh.materials, has_texture)) {
    losses.push_back("materials are written to .glb only");
  }
  return losses;
}

void check_mesh_name(const std::string& path, MeshSpace space) {
  encoding_for(path);
  if (path.ends_with(".glb") && space == MeshSpace::kRas) {
    throw UsageError("--space", "glTF has axes of its own, neither LPS nor RAS",
                     "leave it out, or write another format");
  }
}

void write_mesh(const std::string& path, const Mesh& mesh, MeshSpace space) {
  check_mesh_name(path, space);
  write_whole_file(path, encoding_for(path).encode(mesh, space));
}

}  // namespace isolux
