#include "isolux/render/shown_layer.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <utility>

#include "isolux/base/parallel.h"

namespace isolux {
namespace {

using Bytes = std::array<std::uint8_t, 3>;
using Colors = std::vector<Bytes>;

// From below to above zero, which is a light grey: ColorBrewer's RdBu (Brewer 2002), turned round.
const Colors& diverging() {
  static const Colors colors = {{33, 102, 172},  {103, 169, 207}, {209, 229, 240}, {247, 247, 247},
                                {253, 219, 199}, {239, 138, 98},  {178, 24, 43}};
  return colors;
}

// From near to far, falling evenly in lightness: viridis (Smith and van der Walt 2015), backwards.
const Colors& sequential() {
  static const Colors colors = {
      {253, 231, 37}, {94, 201, 98}, {33, 145, 140}, {59, 82, 139}, {68, 1, 84}};
  return colors;
}

Bytes color_at(const Legend& legend, double value) {
  const double range = legend.high - legend.low;
  const double share = range > 0 ? std::clamp((value - legend.low) / range, 0.0, 1.0) : 0;
  const double place = share * static_cast<double>(legend.colors.size() - 1);
  const auto first = std::min(static_cast<std::size_t>(place), legend.colors.size() - 2);
  const double between = place - static_cast<double>(first);
  Bytes color{};
  for (std::size_t c = 0; c < 3; ++c) {
    const double from = legend.colors[first][c], to = legend.colors[first + 1][c];
    color[c] = static_cast<std::uint8_t>(std::lround(from + between * (to - from)));
  }
  return color;
}

// A picture whose pixels are `of_hit(x, y)` where a surface is met.
Picture painted(const Scene& scene, const SurfaceBuffer& buffer,
                const std::function<Bytes(int x, int y)>& of_hit) {
  Picture picture{buffer.width(), buffer.height(), {}};
  picture.rgb.resize(3 * static_cast<std::size_t>(buffer.width()) *
                     static_cast<std::size_t>(buffer.height()));
  const Bytes background = displayed(scene.display, scene.background);
  parallel_for(
      static_cast<std::size_t>(buffer.height()), 16, [&](std::size_t begin, std::size_t end) {
        auto out = picture.rgb.begin() + static_cast<std::ptrdiff_t>(3 * begin) * buffer.width();
        for (int y = static_cast<int>(begin); y < static_cast<int>(end); ++y) {
          for (int x = 0; x < buffer.width(); ++x) {
            const bool is_hit = buffer.is_hit(buffer.at(x, y));
            out = std::ranges::copy(is_hit ? of_hit(x, y) : background, out).out;
          }
        }
      });
  return picture;
}

Picture term(const Scene& scene, const RgbLayer& layer, const SurfaceBuffer& buffer) {
  return painted(scene, buffer,
                 [&](int x, int y) { return displayed(scene.display, layer.at(buffer.at(x, y))); });
}

ShownPicture cosine(const Scene& scene, const SurfaceBuffer& buffer, const Light& light,
                    double LightTerms::*which) {
  const Legend legend{-1, 1, "", diverging()};
  return {painted(scene, buffer,
                  [&](int x, int y) {
                    const SurfaceSample sample = buffer.sample(buffer.at(x, y));
                    const Ray ray = scene.camera->ray(x, y);
                    const auto& item = scene.surfaces[static_cast<std::size_t>(sample.surface)];
                    return color_at(legend, light_terms(material_at(item, sample.point), light,
                                                        point_of(ray, sample)).*
                                                which);
                  }),
          legend};
}

Picture normals(const Scene& scene, const SurfaceBuffer& buffer) {
  return painted(scene, buffer, [&](int x, int y) {
    const Vec3 n = buffer.sample(buffer.at(x, y)).normal();
    Bytes color{};
    for (int axis = 0; axis < 3; ++axis) {
      color[static_cast<std::size_t>(axis)] =
          static_cast<std::uint8_t>(std::lround(127.5 * (n[axis] + 1)));
    }
    return color;
  });
}

ShownPicture depth(const Scene& scene, const SurfaceBuffer& buffer) {
  Legend legend{0, 0, "mm", sequential()};
  bool any = false;
  for (std::size_t place = 0; place < buffer.pixels(); ++place) {
    if (!buffer.is_hit(place)) continue;
    const double mm = buffer.depth_mm[place];
    legend.low = any ? std::min(legend.low, mm) : mm;
    legend.high = any ? std::max(legend.high, mm) : mm;
    any = true;
  }
  return {painted(scene, buffer,
                  [&](int x, int y) { return color_at(legend, buffer.depth_mm[buffer.at(x, y)]); }),
          legend};
}

}  // namespace

std::span<const std::pair<std::string_view, ShownLayer>> shown_layers() {
  using enum ShownLayer;
  static constexpr std::pair<std::string_view, ShownLayer> kLayers[] = {
      {"picture", kPicture},   {"direct", kDirect},      {"ambient", kAmbient},
      {"diffuse", kDiffuse},   {"specular", kSpecular},  {"mirror", kMirror},
      {"indirect", kIndirect}, {"cos-theta", kCosTheta}, {"cos-phi", kCosPhi},
      {"normal", kNormal},     {"depth", kDepth}};
  return kLayers;
}

std::optional<ShownLayer> shown_layer_named(std::string_view name) {
  for (const auto& [known, layer] : shown_layers()) {
    if (known == name) return layer;
  }
  return std::nullopt;
}

ShownPicture show_layer(ShownLayer layer, const Scene& scene, std::size_t light, Session& session) {
  const Light& lamp = scene.lights[std::min(light, scene.lights.size() - 1)];
  switch (layer) {
    case ShownLayer::kPicture:
      return {session.picture(scene), {}};
    case ShownLayer::kDirect:
      return {session.direct_picture(scene), {}};
    case ShownLayer::kAmbient:
      return {term(scene, session.radiance(scene).ambient, session.surfaces(scene)), {}};
    case ShownLayer::kDiffuse:
      return {term(scene, session.radiance(scene).diffuse, session.surfaces(scene)), {}};
    case ShownLayer::kSpecular:
      return {term(scene, session.radiance(scene).specular, session.surfaces(scene)), {}};
    case ShownLayer::kMirror:
      return {term(scene, session.radiance(scene).mirror, session.surfaces(scene)), {}};
    case ShownLayer::kIndirect:
      return {term(scene, session.radiance(scene).indirect, session.surfaces(scene)), {}};
    case ShownLayer::kCosTheta:
      return cosine(scene, session.surfaces(scene), lamp, &LightTerms::cos_theta);
    case ShownLayer::kCosPhi:
      return cosine(scene, session.surfaces(scene), lamp, &LightTerms::cos_phi);
    case ShownLayer::kNormal:
      return {normals(scene, session.surfaces(scene)), {}};
    case ShownLayer::kDepth:
      return depth(scene, session.surfaces(scene));
  }
  return {session.picture(scene), {}};
}

}  // namespace isolux
