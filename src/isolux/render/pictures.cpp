#include "isolux/render/pictures.h"

#include <string>

#include "isolux/base/memory.h"
#include "isolux/image/exr.h"
#include "isolux/image/png.h"
#include "isolux/render/denoise.h"
#include "isolux/render/relight.h"

namespace isolux {

namespace {

// The share of the pixel that surfaces hide: what the background does not shine through.
float coverage(const Scene& scene, const SurfaceBuffer& buffer, std::size_t place) {
  if (!buffer.is_hit(place)) return 0;
  const auto surface = static_cast<std::size_t>(buffer.surface[place]);
  if (scene.surfaces[surface].material.opacity == 1) return 1;
  for (const FurtherPoint& point : buffer.further[place / SurfaceBuffer::kTilePixels]) {
    if (point.pixel == place % SurfaceBuffer::kTilePixels && !point.is_mirrored &&
        point.surface == FurtherPoint::kBackground) {
      return 1 - point.weight[0];
    }
  }
  return 1;
}

}  // namespace

Layers exr_layers(const Scene& scene, const SurfaceBuffer& buffer, const Radiance& radiance,
                  const Indirect& indirect) {
  Layers layers{buffer.width(), buffer.height(), {}};
  // From the order of tiles to rows.
  const auto add = [&](const std::string& name, auto value_at) {
    std::vector<float> values;
    values.reserve(static_cast<std::size_t>(buffer.width()) *
                   static_cast<std::size_t>(buffer.height()));
    for (int y = 0; y < buffer.height(); ++y) {
      for (int x = 0; x < buffer.width(); ++x) values.push_back(value_at(x, y));
    }
    layers.channels.push_back({name, std::move(values)});
  };
  const auto add_rgb = [&](const std::string& prefix, const RgbLayer& layer) {
    add(prefix + "R", [&](int x, int y) { return layer.r[buffer.at(x, y)]; });
    add(prefix + "G", [&](int x, int y) { return layer.g[buffer.at(x, y)]; });
    add(prefix + "B", [&](int x, int y) { return layer.b[buffer.at(x, y)]; });
  };
  const auto add_sample = [&](const std::string& name, auto of_sample) {
    add(name, [&](int x, int y) {
      return static_cast<float>(of_sample(buffer.sample(buffer.at(x, y))));
    });
  };
  const auto add_position = [&](const std::string& name, int axis) {
    add(name, [&](int x, int y) {
      const SurfaceSample sample = buffer.sample(buffer.at(x, y));
      if (!sample.is_hit()) return 0.0f;
      return static_cast<float>(scene.camera->ray(x, y).at(sample.depth_mm)[axis]);
    });
  };
  add_rgb("", radiance.total);
  add("A", [&](int x, int y) { return coverage(scene, buffer, buffer.at(x, y)); });
  add_rgb("ambient.", radiance.ambient);
  add_rgb("diffuse.", radiance.diffuse);
  add_rgb("specular.", radiance.specular);
  add_rgb("indirect.", radiance.indirect);
  add_rgb("mirror.", radiance.mirror);
  add_sample("normal.X", [](const SurfaceSample& sample) { return sample.normal_x; });
  add_sample("normal.Y", [](const SurfaceSample& sample) { return sample.normal_y; });
  add_sample("normal.Z", [](const SurfaceSample& sample) { return sample.normal_z; });
  add_position("position.X", 0);
  add_position("position.Y", 1);
  add_position("position.Z", 2);
  add_sample("depth.Z", [](const SurfaceSample& sample) { return sample.depth_mm; });
  add_sample("surface.id", [](const SurfaceSample& sample) { return sample.surface; });
  if (!indirect.empty()) {
    add("sky.Y", [&](int x, int y) { return indirect.sky[buffer.at(x, y)]; });
  }
  return layers;
}

std::string encode_picture(const Scene& scene, const SurfaceBuffer& buffer, const Shadows& shadows,
                           const Indirect& indirect, const Metadata& metadata, bool is_exr) {
  if (is_exr) {
    const Radiance radiance = light(scene, buffer, shadows, indirect);
    return encode_exr(exr_layers(scene, buffer, radiance, indirect), metadata);
  }
  const bool is_srgb = scene.display.curve == Display::Curve::kSrgb;
  return encode_png(LitPicture().relight(scene, buffer, shadows, indirect), metadata, is_srgb);
}

void check_picture_memory(const SceneDescription& scene, bool is_exr) {
  // Bytes a pixel of all buffers that live at the same time, rounded up.
  const double bytes_per_pixel =
      (is_exr ? 360 : 96) + (scene.denoise ? Denoiser::kBytesPerPixel : 0);
  check_memory(static_cast<double>(scene.width) * scene.height * bytes_per_pixel, "--size");
}

}  // namespace isolux
