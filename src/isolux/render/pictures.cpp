#include "isolux/render/pictures.h"

#include <algorithm>
#include <string>

#include "isolux/base/memory.h"
#include "isolux/base/parallel.h"
#include "isolux/image/exr.h"
#include "isolux/image/png.h"

namespace isolux {

Picture displayed_picture(const Scene& scene, const Radiance& radiance) {
  Picture picture{scene.camera->width(), scene.camera->height(), {}};
  const std::size_t pixels = radiance.total.r.size();
  picture.rgb.resize(3 * pixels);
  parallel_for(pixels, 16384, [&](std::size_t begin, std::size_t end) {
    for (std::size_t pixel = begin; pixel < end; ++pixel) {
      const auto shown = displayed(scene.display, radiance.total.at(pixel));
      std::ranges::copy(shown, picture.rgb.begin() + static_cast<std::ptrdiff_t>(3 * pixel));
    }
  });
  return picture;
}

Layers exr_layers(const Scene& scene, const SurfaceBuffer& buffer, const Radiance& radiance) {
  const std::size_t pixels = buffer.surface.size();
  Layers layers{buffer.width, buffer.height, {}};
  const auto add = [&](const std::string& name, std::vector<float> values) {
    layers.channels.push_back({name, std::move(values)});
  };
  const auto add_rgb = [&](const std::string& prefix, const RgbLayer& layer) {
    add(prefix + "R", layer.r);
    add(prefix + "G", layer.g);
    add(prefix + "B", layer.b);
  };
  std::vector<float> coverage(pixels), depth(pixels), id(pixels), x(pixels), y(pixels), z(pixels);
  for (int row = 0; row < buffer.height; ++row) {
    for (int column = 0; column < buffer.width; ++column) {
      const std::size_t pixel = buffer.at(column, row);
      const bool hit = buffer.sample(pixel).is_hit();
      coverage[pixel] = hit ? 1 : 0;
      depth[pixel] = static_cast<float>(buffer.depth_mm[pixel]);
      id[pixel] = static_cast<float>(buffer.surface[pixel]);
      if (!hit) continue;
      const Vec3 position = scene.camera->ray(column, row).at(buffer.depth_mm[pixel]);
      x[pixel] = static_cast<float>(position.x);
      y[pixel] = static_cast<float>(position.y);
      z[pixel] = static_cast<float>(position.z);
    }
  }
  add_rgb("", radiance.total);
  add("A", std::move(coverage));
  add_rgb("ambient.", radiance.ambient);
  add_rgb("diffuse.", radiance.diffuse);
  add_rgb("specular.", radiance.specular);
  const RgbLayer none(pixels);  // no indirect light and no mirrors are asked for
  add_rgb("indirect.", none);
  add_rgb("mirror.", none);
  add("normal.X", buffer.normal_x);
  add("normal.Y", buffer.normal_y);
  add("normal.Z", buffer.normal_z);
  add("position.X", std::move(x));
  add("position.Y", std::move(y));
  add("position.Z", std::move(z));
  add("depth.Z", std::move(depth));
  add("surface.id", std::move(id));
  return layers;
}

std::string encode_picture(const Scene& scene, const SurfaceBuffer& buffer,
                           const Radiance& radiance, const Metadata& metadata, bool is_exr) {
  if (is_exr) return encode_exr(exr_layers(scene, buffer, radiance), metadata);
  const bool is_srgb = scene.display.curve == Display::Curve::kSrgb;
  return encode_png(displayed_picture(scene, radiance), metadata, is_srgb);
}

void check_picture_memory(const SceneDescription& scene, bool is_exr) {
  // Bytes a pixel of all buffers that live at the same time, rounded up.
  const double bytes_per_pixel = is_exr ? 360 : 96;
  check_memory(static_cast<double>(scene.width) * scene.height * bytes_per_pixel, "--size");
}

}  // namespace isolux
