#include <cmath>
#include <limits>
#include <nlohmann/json.hpp>

#include "isolux/base/error.h"
#include "isolux/image/png.h"
#include "isolux/io/mesh_encoders.h"
#include "isolux/mesh/mesh_box.h"

// glTF 2.0 in its binary form: a JSON document that names stretches of one buffer, then the buffer.

namespace isolux {
namespace {

using nlohmann::json;

constexpr int kFloat = 5126, kUnsignedInt = 5125;            // componentType
constexpr int kArrayBuffer = 34962, kElementBuffer = 34963;  // bufferView.target

json numbers(Rgb c) { return {c.r, c.g, c.b}; }

// A document under construction, with its buffer.
class Glb {
 public:
  json document = {{"asset", {{"version", "2.0"}, {"generator", "isolux"}}}, {"scene", 0}};

  /// Adds a stretch to the buffer; returns its number.
  int add_view(const void* bytes, std::size_t count, int target) {
    json view = {{"buffer", 0}, {"byteOffset", buffer_.size()}, {"byteLength", count}};
    if (target != 0) view["target"] = target;
    buffer_.append(static_cast<const char*>(bytes), count);
    buffer_.resize((buffer_.size() + 3) / 4 * 4);
    document["bufferViews"].push_back(view);
    return static_cast<int>(document["bufferViews"].size()) - 1;
  }

  /// Adds an accessor; returns its number.
  int add_accessor(const json& accessor) {
    document["accessors"].push_back(accessor);
    return static_cast<int>(document["accessors"].size()) - 1;
  }

  /// The whole file.
  std::string bytes() {
    document["buffers"].push_back({{"byteLength", buffer_.size()}});
    std::string text = document.dump();
    text.resize((text.size() + 3) / 4 * 4, ' ');
    const std::size_t total = 12 + 8 + text.size() + 8 + buffer_.size();
    if (total > std::numeric_limits<std::uint32_t>::max()) {
      throw WorkError("glTF", "a .glb holds at most 4 GB", "write .ply, or use --decimate");
    }
    std::string file = "glTF";
    for (const std::size_t word : {std::size_t{2}, total, text.size()}) append_word(file, word);
    file += "JSON" + text;
    append_word(file, buffer_.size());
    return file.append("BIN\0", 4).append(buffer_);
  }

 private:
  static void append_word(std::string& file, std::size_t word) {
    for (int n = 0; n < 4; ++n) file += static_cast<char>(word >> (8 * n));
  }

  std::string buffer_;
};

template <typename T>
int add_vertices(Glb& glb, const std::vector<T>& values, const char* type) {
  const int view = glb.add_view(values.data(), values.size() * sizeof(T), kArrayBuffer);
  return glb.add_accessor(
      {{"bufferView", view}, {"componentType", kFloat}, {"count", values.size()}, {"type", type}});
}

int add_positions(Glb& glb, const Mesh& mesh) {
  const int accessor = add_vertices(glb, mesh.positions, "VEC3");
  const MeshBox box = box_of(mesh);
  glb.document["accessors"][static_cast<std::size_t>(accessor)].update(
      {{"min", {box.low.x, box.low.y, box.low.z}}, {"max", {box.high.x, box.high.y, box.high.z}}});
  return accessor;
}

// glTF's texture points run down from the upper left corner.
std::vector<TexturePoint> turned_down(std::vector<TexturePoint> points) {
  for (TexturePoint& point : points) point.v = 1 - point.v;
  return points;
}

void add_base_color(Glb& glb, const Picture& picture, json& material) {
  const std::string png = encode_png(picture, {}, true);
  const int view = glb.add_view(png.data(), png.size(), 0);
  glb.document["images"].push_back({{"bufferView", view}, {"mimeType", "image/png"}});
  glb.document["textures"].push_back({{"source", glb.document["images"].size() - 1}});
  material["pbrMetallicRoughness"]["baseColorTexture"] = {
      {"index", glb.document["textures"].size() - 1}};
}

// The nearest that glTF has to Phong's model; the model's own numbers go along as extras.
json material_of(Glb& glb, const MeshMaterial& from) {
  const Material& m = from.material;
  // Phong's lobe of exponent n is about as wide as that of roughness (2 / (n + 2)) ^ (1/4).
  const double roughness = std::sqrt(std::sqrt(2 / (m.shininess + 2)));
  json material = {{"name", from.name},
                   {"doubleSided", true},
                   {"pbrMetallicRoughness",
                    {{"baseColorFactor", {m.kd.r, m.kd.g, m.kd.b, 1}},
                     {"metallicFactor", 0},
                     {"roughnessFactor", roughness}}},
                   {"extras",
                    {{"isolux",
                      {{"ka", numbers(m.ka)},
                       {"kd", numbers(m.kd)},
                       {"ks", numbers(m.ks)},
                       {"shininess", m.shininess}}}}}};
  if (from.base_color) add_base_color(glb, *from.base_color, material);
  return material;
}

}  // namespace

std::string as_glb(const Mesh& mesh, MeshSpace) {
  Glb glb;
  json attributes = {{"POSITION", add_positions(glb, mesh)}};
  if (!mesh.normals.empty()) attributes["NORMAL"] = add_vertices(glb, mesh.normals, "VEC3");
  if (!mesh.colors.empty()) attributes["COLOR_0"] = add_vertices(glb, mesh.colors, "VEC3");
  if (!mesh.texture_points.empty()) {
    attributes["TEXCOORD_0"] = add_vertices(glb, turned_down(mesh.texture_points), "VEC2");
  }
  const int view = glb.add_view(mesh.triangles.data(),
                                mesh.triangles.size() * sizeof(Mesh::Triangle), kElementBuffer);
  json primitives = json::array();
  for (const MeshPart& part : mesh.parts) {
    const int indices =
        glb.add_accessor({{"bufferView", view},
                          {"byteOffset", sizeof(Mesh::Triangle) * part.first_triangle},
                          {"componentType", kUnsignedInt},
                          {"count", 3 * part.triangle_count},
                          {"type", "SCALAR"}});
    primitives.push_back(
        {{"attributes", attributes}, {"indices", indices}, {"material", part.material}});
  }
  for (const MeshMaterial& material : mesh.materials) {
    const json encoded = material_of(glb, material);
    glb.document["materials"].push_back(encoded);
  }
  glb.document["meshes"].push_back({{"primitives", primitives}});
  // LPS millimetres to metres with +y up and +z to the front (anterior): columns of the matrix.
  const json matrix = {0.001, 0, 0, 0, 0, 0, -0.001, 0, 0, 0.001, 0, 0, 0, 0, 0, 1};
  glb.document["nodes"].push_back({{"name", "isolux"}, {"mesh", 0}, {"matrix", matrix}});
  glb.document["scenes"].push_back({{"nodes", json::array({0})}});
  return glb.bytes();
}

}  // namespace isolux
