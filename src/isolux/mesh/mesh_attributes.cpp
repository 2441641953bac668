#include "isolux/mesh/mesh_attributes.h"

#include <algorithm>
#include <cmath>

#include "isolux/image/display.h"

namespace isolux {
namespace {

template <typename Get>
auto blended(const Mesh& mesh, const MeshPoint& point, const Get& get) {
  const Mesh::Triangle& t = mesh.triangles[point.triangle];
  const double u = point.u, v = point.v;
  return (1 - u - v) * get(t[0]) + u * get(t[1]) + v * get(t[2]);
}

const MeshMaterial& material_of(const Mesh& mesh, std::uint32_t triangle) {
  const auto after = std::ranges::upper_bound(mesh.parts, triangle, {}, &MeshPart::first_triangle);
  return mesh.materials[std::prev(after)->material];
}

double linear_from_byte(std::uint8_t byte) {
  static const auto table = [] {
    std::array<double, 256> values{};
    for (std::size_t n = 0; n < values.size(); ++n) {
      values[n] = linear_from_srgb(static_cast<double>(n) / 255);
    }
    return values;
  }();
  return table[byte];
}

Rgb texel(const Picture& picture, long long x, long long y) {
  const auto wrapped = [](long long n, int count) {
    return static_cast<std::size_t>((n % count + count) % count);
  };
  const std::size_t at = 3 * (wrapped(y, picture.height) * static_cast<std::size_t>(picture.width) +
                              wrapped(x, picture.width));
  return {linear_from_byte(picture.rgb[at]), linear_from_byte(picture.rgb[at + 1]),
          linear_from_byte(picture.rgb[at + 2])};
}

Rgb texture_at(const Picture& picture, double u, double v) {
  // Pixel centres lie at half numbers, row 0 on top.
  const double x = (u - std::floor(u)) * picture.width - 0.5;
  const double y = (1 - (v - std::floor(v))) * picture.height - 0.5;
  const auto left = static_cast<long long>(std::floor(x));
  const auto top = static_cast<long long>(std::floor(y));
  const double right_share = x - std::floor(x), low_share = y - std::floor(y);
  const auto row = [&](long long at) {
    return (1 - right_share) * texel(picture, left, at) +
           right_share * texel(picture, left + 1, at);
  };
  return (1 - low_share) * row(top) + low_share * row(top + 1);
}

}  // namespace

Vec3 shading_normal(const Mesh& mesh, const MeshPoint& point) {
  if (!mesh.normals.empty()) {
    const Vec3 normal =
        blended(mesh, point, [&](std::uint32_t n) { return as_double(mesh.normals[n]); });
    if (normal != Vec3{}) return (1 / length(normal)) * normal;
  }
  const auto [a, b, c] = corners(mesh, mesh.triangles[point.triangle]);
  const Vec3 normal = cross(b - a, c - a);
  return normal == Vec3{} ? normal : (1 / length(normal)) * normal;
}

Material material_at(const Mesh& mesh, const MeshPoint& point) {
  const MeshMaterial& from = material_of(mesh, point.triangle);
  Rgb color{1, 1, 1};
  if (!mesh.colors.empty()) {
    const Vec3 c = blended(mesh, point, [&](std::uint32_t n) { return as_double(mesh.colors[n]); });
    color = {c.x, c.y, c.z};
  }
  if (from.base_color && !mesh.texture_points.empty()) {
    const Vec3 at = blended(mesh, point, [&](std::uint32_t n) {
      return Vec3{mesh.texture_points[n].u, mesh.texture_points[n].v, 0};
    });
    color = color * texture_at(*from.base_color, at.x, at.y);
  }
  Material material = from.material;
  material.ka = color * material.ka;
  material.kd = color * material.kd;
  return material;
}

bool has_one_material(const Mesh& mesh) {
  if (!mesh.colors.empty()) return false;
  const std::uint32_t first = mesh.parts.at(0).material;
  const auto is_first = [&](const MeshPart& part) { return part.material == first; };
  return mesh.materials[first].base_color == nullptr && std::ranges::all_of(mesh.parts, is_first);
}

}  // namespace isolux
