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

Inputs::Inputs(const Scene& s, const SurfaceBuffer& b) : scene(&s), buffer(&b) {
  for (const IsoSurfaceItem& item : s.surfaces) {
    Surface& surface = surfaces.emplace_back();
    set(surface.ambient, ambient_term(item.material, s.ambient));
    set(surface.kd, item.material.kd);
    set(surface.ks, item.material.ks);
    surface.shininess = static_cast<float>(item.material.shininess);
  }
  const RayFan fan = s.camera->fan();
  const Vec3 eye = s.camera->eye();
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

void light_plainly(const Inputs& in, std::size_t begin, std::size_t end, const Outputs& out) {
  PixelTerms terms;
  each_pixel(*in.buffer, begin, end, [&](std::size_t place, int x, int y) {
    const SurfaceSample sample = in.buffer->sample(place);
    if (!sample.is_hit()) return;
    light_sample(*in.scene, in.scene->camera->ray(in.first_x + x, in.first_y + y), sample, terms);
    out.total->set(place, terms.total);
    if (!out.ambient) return;
    out.ambient->set(place, terms.ambient);
    out.diffuse->set(place, terms.diffuse);
    out.specular->set(place, terms.specular);
  });
  if (out.picture) show_plainly(in, begin, end, out);
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

Radiance light(const Scene& scene, const SurfaceBuffer& buffer) {
  Radiance radiance(buffer.pixels());
  const Inputs in(scene, buffer);
  const Outputs out{.total = &radiance.total,
                    .ambient = &radiance.ambient,
                    .diffuse = &radiance.diffuse,
                    .specular = &radiance.specular};
  parallel_for(buffer.hits.size(), kTilesAPiece, [&](std::size_t begin, std::size_t end) {
    for (std::size_t place = 64 * begin; place < 64 * end; ++place) {
      radiance.total.set(place, scene.background);
    }
    relighting::light(in, begin, end, out);
  });
  return radiance;
}

Rgb light_pixel(const Scene& scene, const SurfaceSample& sample, int x, int y) {
  SurfaceBuffer buffer(SurfaceBuffer::kTile, SurfaceBuffer::kTile);
  const std::size_t place = buffer.at(x % SurfaceBuffer::kTile, y % SurfaceBuffer::kTile);
  buffer.set(place, sample);
  RgbLayer total(buffer.pixels());
  Inputs in(scene, buffer);
  in.first_x = x - x % SurfaceBuffer::kTile;
  in.first_y = y - y % SurfaceBuffer::kTile;
  relighting::light(in, 0, 1, {.total = &total});
  return total.at(place);
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

const Picture& LitPicture::relight(const Scene& scene, const SurfaceBuffer& buffer) {
  return draw(scene, buffer, relighting::light);
}

const Picture& LitPicture::redisplay(const Scene& scene, const SurfaceBuffer& buffer) {
  return draw(scene, buffer, relighting::show);
}

const Picture& LitPicture::draw(const Scene& scene, const SurfaceBuffer& buffer, Stage stage) {
  prepare(scene, buffer);
  Inputs in(scene, buffer);
  in.table = &*table_;
  in.background_bytes = background_;
  const Outputs out{.total = &*total_, .picture = &picture_, .drawn = &drawn_};
  parallel_for(buffer.hits.size(), kTilesAPiece,
               [&](std::size_t begin, std::size_t end) { stage(in, begin, end, out); });
  drawn_ = buffer.hits;
  return picture_;
}

}  // namespace isolux
