#include "isolux/render/relight.h"

#include <algorithm>
#include <cstring>

#include "isolux/base/parallel.h"
#include "isolux/render/relight_inputs.h"

namespace isolux {
namespace {

using relighting::Inputs;
using relighting::Outputs;

constexpr std::size_t kTilesAPiece = 256;

void set(float (&out)[3], Rgb value) {
  for (int c = 0; c < 3; ++c) out[c] = static_cast<float>(value[c]);
}

void set(float (&out)[3], Vec3 value) {
  for (int a = 0; a < 3; ++a) out[a] = static_cast<float>(value[a]);
}

// Calls body(place, x, y) for the pixels of tiles [begin, end) that lie in the picture.
template <typename Body>
void each_pixel(const SurfaceBuffer& buffer, std::size_t begin, std::size_t end, Body body) {
  const auto tiles_x = static_cast<std::size_t>(buffer.tiles_x());
  for (std::size_t tile = begin; tile < end; ++tile) {
    const int x0 = static_cast<int>(8 * (tile % tiles_x)),
              y0 = static_cast<int>(8 * (tile / tiles_x));
    for (int y = y0; y < std::min(y0 + 8, buffer.height()); ++y) {
      for (int x = x0; x < std::min(x0 + 8, buffer.width()); ++x) body(buffer.at(x, y), x, y);
    }
  }
}

std::uint32_t shown(const DisplayTable& table, Rgb radiance) {
  std::uint32_t bytes = 0;
  for (int c = 0; c < 3; ++c) {
    bytes |= std::uint32_t{table.byte(static_cast<float>(radiance[c]))} << (8 * c);
  }
  return bytes;
}

}  // namespace

namespace relighting {

Inputs::Inputs(const Scene& s, const SurfaceBuffer& b, const Shadows& v, const Indirect& i)
    : scene(&s), buffer(&b), shadows(&v), indirect(&i), eye(s.camera->eye()) {
  set(background, s.background);
  for (const SurfaceItem& item : s.surfaces) {
    Surface& surface = surfaces.emplace_back();
    const double opacity = item.material.opacity;
    set(surface.ambient, opacity * ambient_term(item.material, s.ambient));
    set(surface.kd, opacity * item.material.kd);
    set(surface.ks, opacity * item.material.ks);
    has_painted |= item.is_painted;
    surface.shininess = static_cast<float>(item.material.shininess);
  }
  const RayFan fan = s.camera->fan();
  for (const Light& light : s.lights) {
    Lamp& lamp = lamps.emplace_back();
    lamp.is_point = light.kind == Light::Kind::kPoint;
    set(lamp.place, lamp.is_point ? light.place - eye : normalize(light.place));
    set(lamp.intensity, light.intensity);
    const double reference = light.inverse_square_reference_mm.value_or(0);
    lamp.reference_square = static_cast<float>(reference * reference);
  }
  is_orthographic = s.camera->is_orthographic();
  set(origin[0], fan.origin.first - eye);
  set(origin[1], fan.origin.along_x);
  set(origin[2], fan.origin.along_y);
  set(direction[0], fan.direction.first);
  set(direction[1], fan.direction.along_x);
  set(direction[2], fan.direction.along_y);
}

namespace {

// Lights the pixels of tiles [begin, end) whose surface `wanted` says.
template <typename Wanted>
void light_each(const Inputs& in, std::size_t begin, std::size_t end, const Outputs& out,
                const Wanted& wanted) {
  PointTerms terms;
  each_pixel(*in.buffer, begin, end, [&](std::size_t place, int x, int y) {
    const SurfaceSample sample = in.buffer->sample(place);
    if (!sample.is_hit()) return;
    const SurfaceItem& item = in.scene->surfaces[static_cast<std::size_t>(sample.surface)];
    if (!wanted(item)) return;
    const Ray ray = in.scene->camera->ray(in.buffer->first_x + x, in.buffer->first_y + y);
    const auto irradiance = in.indirect->of_pixel(place);
    light_point(*in.scene, sample.surface, sample.point, point_of(ray, sample),
                in.shadows->of_pixel(place), irradiance ? &*irradiance : nullptr, terms);
    const double opacity = item.material.opacity;
    out.total->set(place, opacity * terms.total);
    if (!out.ambient) return;
    out.ambient->set(place, opacity * (terms.ambient + terms.indirect));
    out.diffuse->set(place, opacity * terms.diffuse);
    out.specular->set(place, opacity * terms.specular);
  });
}

}  // namespace

void light_painted(const Inputs& in, std::size_t begin, std::size_t end, const Outputs& out) {
  light_each(in, begin, end, out, [](const SurfaceItem& item) { return item.is_painted; });
}

void light_plainly(const Inputs& in, std::size_t begin, std::size_t end, const Outputs& out) {
  light_each(in, begin, end, out, [](const SurfaceItem&) { return true; });
  if (out.picture) show_plainly(in, begin, end, out);
}

void add_further(const Inputs& in, std::size_t tile, const FurtherPoint& point,
                 const float (&ambient)[3], const float (&diffuse)[3], const float (&specular)[3],
                 const Outputs& out) {
  const std::size_t place = SurfaceBuffer::kTilePixels * tile + point.pixel;
  const bool is_background = point.surface == FurtherPoint::kBackground;
  for (int c = 0; c < 3; ++c) {
    const float w = point.weight[c];
    const float sum =
        w * (is_background ? in.background[c] : ambient[c] + diffuse[c] + specular[c]);
    out.total->channel(c)[place] += sum;
    if (!out.ambient) continue;
    if (point.is_mirrored) {
      out.mirror->channel(c)[place] += sum;
    } else if (!is_background) {
      out.ambient->channel(c)[place] += w * ambient[c];
      out.diffuse->channel(c)[place] += w * diffuse[c];
      out.specular->channel(c)[place] += w * specular[c];
    }
  }
}

void add_further_plainly(const Inputs& in, std::size_t tile, std::size_t n, const Outputs& out) {
  const FurtherPoint& point = in.buffer->further[tile][n];
  float ambient[3] = {}, diffuse[3] = {}, specular[3] = {};
  if (point.surface != FurtherPoint::kBackground) {
    PointTerms terms;
    const auto irradiance = in.indirect->of_further(tile, n);
    light_point(*in.scene, point.surface, point.point, point_of(point),
                in.shadows->of_further(tile, n), irradiance ? &*irradiance : nullptr, terms);
    const double opacity =
        in.scene->surfaces[static_cast<std::size_t>(point.surface)].material.opacity;
    set(ambient, opacity * (terms.ambient + terms.indirect));
    set(diffuse, opacity * terms.diffuse);
    set(specular, opacity * terms.specular);
  }
  add_further(in, tile, point, ambient, diffuse, specular, out);
}

void light_further_plainly(const Inputs& in, std::size_t begin, std::size_t end,
                           const Outputs& out) {
  for (std::size_t tile = begin; tile < end; ++tile) {
    for (std::size_t n = 0; n < in.buffer->further[tile].size(); ++n) {
      add_further_plainly(in, tile, n, out);
    }
  }
}

void show_plainly(const Inputs& in, std::size_t begin, std::size_t end, const Outputs& out) {
  each_pixel(*in.buffer, begin, end, [&](std::size_t place, int x, int y) {
    const std::uint32_t bytes =
        in.buffer->is_hit(place) ? shown(*in.table, out.total->at(place)) : in.background_bytes;
    std::memcpy(
        &out.picture
             ->rgb[3 * (static_cast<std::size_t>(y) * static_cast<std::size_t>(out.picture->width) +
                        static_cast<std::size_t>(x))],
        &bytes, 3);
  });
}

void write_block(const std::uint32_t* pixels, Picture& picture, int x0, int y0) {
  if (x0 >= picture.width) return;
  const auto columns = static_cast<std::size_t>(std::min(4, picture.width - x0));
  for (int row = 0; row < std::min(4, picture.height - y0); ++row) {
    const std::uint32_t* p = pixels + 4 * row;
    std::uint32_t packed[3] = {p[0] | p[1] << 24, p[1] >> 8 | p[2] << 16, p[2] >> 16 | p[3] << 8};
    const std::size_t at =
        static_cast<std::size_t>(y0 + row) * static_cast<std::size_t>(picture.width) +
        static_cast<std::size_t>(x0);
    if (columns == 4) {
      std::memcpy(&picture.rgb[3 * at], packed, 12);
    } else {
      std::memcpy(&picture.rgb[3 * at], packed, 3 * columns);
    }
  }
}

}  // namespace relighting

Radiance light(const Scene& scene, const SurfaceBuffer& buffer, const Shadows& shadows,
               const Indirect& indirect) {
  Radiance radiance(buffer.pixels());
  const Inputs in(scene, buffer, shadows, indirect);
  const Outputs out{.total = &radiance.total,
                    .ambient = indirect.empty() ? &radiance.ambient : &radiance.indirect,
                    .diffuse = &radiance.diffuse,
                    .specular = &radiance.specular,
                    .mirror = &radiance.mirror};
  parallel_for(buffer.hits.size(), kTilesAPiece, [&](std::size_t begin, std::size_t end) {
    for (std::size_t place = 64 * begin; place < 64 * end; ++place) {
      radiance.total.set(place, scene.background);
    }
    relighting::light(in, begin, end, out);
  });
  return radiance;
}

void LitPicture::prepare(const Scene& scene, const SurfaceBuffer& buffer) {
  if (!table_ || !(table_->display() == scene.display)) table_.emplace(scene.display);
  const std::uint32_t background = shown(*table_, scene.background);
  const std::size_t bytes =
      3 * static_cast<std::size_t>(buffer.width()) * static_cast<std::size_t>(buffer.height());
  if (picture_.width != buffer.width() || picture_.height != buffer.height()) {
    picture_ = {buffer.width(), buffer.height(), std::vector<std::uint8_t>(bytes)};
    total_.emplace(buffer.pixels());
    drawn_.clear();
  }
  if (drawn_.empty() || background != background_) drawn_.assign(buffer.hits.size(), ~0ull);
  background_ = background;
}

const Picture& LitPicture::relight(const Scene& scene, const SurfaceBuffer& buffer,
                                   const Shadows& shadows, const Indirect& indirect) {
  return draw(scene, buffer, shadows, indirect, relighting::light);
}

const Picture& LitPicture::redisplay(const Scene& scene, const SurfaceBuffer& buffer) {
  return draw(scene, buffer, {}, {}, relighting::show);
}

const Picture& LitPicture::draw(const Scene& scene, const SurfaceBuffer& buffer,
                                const Shadows& shadows, const Indirect& indirect, Stage stage) {
  prepare(scene, buffer);
  Inputs in(scene, buffer, shadows, indirect);
  in.table = &*table_;
  in.background_bytes = background_;
  const Outputs out{.total = &*total_, .picture = &picture_, .drawn = &drawn_};
  parallel_for(buffer.hits.size(), kTilesAPiece,
               [&](std::size_t begin, std::size_t end) { stage(in, begin, end, out); });
  drawn_ = buffer.hits;
  return picture_;
}

}  // namespace isolux
