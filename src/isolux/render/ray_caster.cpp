#include "isolux/render/ray_caster.h"

#include <algorithm>
#include <array>
#include <atomic>
#include <bit>
#include <cmath>
#include <limits>
#include <span>
#include <variant>

#include "isolux/base/memory.h"
#include "isolux/base/parallel.h"
#include "isolux/render/fan_lanes.h"
#include "isolux/render/further_points.h"
#include "isolux/render/mesh_view.h"
#include "isolux/render/tile_bounds.h"

namespace isolux {
namespace {

constexpr int kLanes = RayLanes::kCount;
static_assert(kLanes == 2 * SurfaceBuffer::kBlockPixels);

constexpr std::size_t kHalvesAtOnce = IsoLanes::kPacketsAtOnce;

// Rays this many cells apart pass through the volume more quickly each for itself.
constexpr double kBeamCells = 0.6;

}  // namespace

// What one camera sees of a caster's surfaces.
class RayCaster::Eye {
 public:
  // Of a tile, the upper or lower one: the pixels of a packet.
  struct Half {
    std::size_t place;  // of its first pixel in a buffer
    int x0, y0;
  };

  Eye(const SceneSurfaces& surfaces, Visibility visibility, const Camera& camera)
      : width_(camera.width()), height_(camera.height()), world_(camera.fan()) {
    for (const PreparedSurface& surface : surfaces.all()) {
      if (surface.lanes()) {
        views_.emplace_back(IsoView(*surface.lanes(), world_, camera));
      } else if (visibility == Visibility::kRaster) {
        views_.emplace_back(SeenMesh{surface.mesh(), {*surface.mesh(), camera}});
      } else {
        views_.emplace_back(SeenMesh{surface.mesh(), {surface.tree(), camera}});
      }
    }
  }

  // Whether row y is in the picture.
  bool sees(int y) const { return y < height_; }

  // Whether anything can be met in the 8 x 4 pixels from (x0, y0).
  bool may_meet(int x0, int y0) const {
    return std::ranges::any_of(views_, [&](const auto& view) {
      const auto* iso = std::get_if<IsoView>(&view);
      return iso ? iso->blocks(x0, y0, width_) != 0
                 : !std::get<SeenMesh>(view).view.is_empty_at(x0, y0);
    });
  }

  // What some halves of tiles see, no more than kHalvesAtOnce.
  void trace(std::span<const Half> halves, std::span<PacketHits> nearest) const {
    for (std::size_t n = 0; n < views_.size(); ++n) {
      const auto number = static_cast<std::int32_t>(n);
      if (const auto* iso = std::get_if<IsoView>(&views_[n])) {
        trace_iso(*iso, number, halves, nearest);
        continue;
      }
      for (std::size_t h = 0; h < halves.size(); ++h) {
        trace_mesh(std::get<SeenMesh>(views_[n]), number, halves[h], nearest[h]);
      }
    }
    for (std::size_t h = 0; h < halves.size(); ++h) {
      if (nearest[h].hit != 0) finish(halves[h], nearest[h]);
    }
  }

  // The rays of one, of unit direction.
  RayPacket rays(const Half& half) const {
    RayPacket packet;
    aim_unit(world_, half.x0, half.y0, packet);
    return packet;
  }

 private:
  struct IsoView {
    const IsoLanes* lanes;
    RayFan fan;  // in the index space of the surface's volume
    TileBounds bounds;

    IsoView(const IsoLanes& of, const RayFan& world, const Camera& camera)
        : lanes(&of),
          fan(carried(of.surface().index_from_world(), world)),
          bounds(of.skip(), of.surface().volume().world_from_index, camera) {}

    // Which of the two blocks of 4 x 4 pixels from (x0, y0) can show the surface: a bit for each.
    unsigned blocks(int x0, int y0, int width) const {
      unsigned blocks = 0;
      for (int block = 0; block < 2 && x0 + 4 * block < width; ++block) {
        const std::size_t at = bounds.at(x0 + 4 * block, y0);
        if (bounds.near[at] <= bounds.far[at]) blocks |= 1u << block;
      }
      return blocks;
    }

    // How far neighbouring rays are from each other, in index space.
    double cells_apart(double t) const {
      return std::max(length(fan.origin.along_x + t * fan.direction.along_x),
                      length(fan.origin.along_y + t * fan.direction.along_y));
    }
  };
  struct SeenMesh {
    const Mesh* mesh;
    MeshView view;
  };

  void trace_iso(const IsoView& view, std::int32_t number, std::span<const Half> halves,
                 std::span<PacketHits> nearest) const {
    // Where neighbours are far from each other, all that there are go in one stream.
    std::array<RayLanes, kHalvesAtOnce> loose;
    std::array<std::uint32_t, kHalvesAtOnce> lanes;
    std::array<std::size_t, kHalvesAtOnce> half_of;
    std::size_t count = 0;
    for (std::size_t h = 0; h < halves.size(); ++h) {
      RayLanes& rays = loose[count];
      lanes[count] = aim_at(view, halves[h], rays);
      if (lanes[count] == 0) continue;
      if (!rays.is_beam) {
        half_of[count++] = h;
        continue;
      }
      HitLanes hits;
      view.lanes->first_hits(rays, lanes[count], hits);
      nearest[h].add(hits, number);
    }
    if (count == 0) return;
    std::array<HitLanes, kHalvesAtOnce> hits;
    view.lanes->first_hits(std::span(loose).first(count), std::span(lanes).first(count),
                           std::span(hits).first(count));
    for (std::size_t n = 0; n < count; ++n) nearest[half_of[n]].add(hits[n], number);
  }

  // The rays of a half towards an isosurface; returns those that can meet it.
  std::uint32_t aim_at(const IsoView& view, const Half& half, RayLanes& rays) const {
    std::uint32_t lanes = 0;
    float nearest_t = std::numeric_limits<float>::infinity();
    const unsigned blocks = view.blocks(half.x0, half.y0, width_);
    for (int block = 0; block < 2; ++block) {
      if (!(blocks >> block & 1)) continue;
      const std::size_t at = view.bounds.at(half.x0 + 4 * block, half.y0);
      lanes |= 0xFFFFu << (16 * block);
      nearest_t = std::min(nearest_t, view.bounds.near[at]);
      std::fill_n(rays.begin + 16 * block, 16, view.bounds.near[at]);
      std::fill_n(rays.end + 16 * block, 16, view.bounds.far[at]);
    }
    lanes &= pixels_inside(half.x0, half.y0);
    if (lanes == 0) return 0;
    aim(view.fan, half.x0, half.y0, rays);
    rays.is_beam = view.cells_apart(nearest_t) < kBeamCells;
    return lanes;
  }

  void trace_mesh(const SeenMesh& seen, std::int32_t number, const Half& half,
                  PacketHits& nearest) const {
    const auto [place, x0, y0] = half;
    if (seen.view.is_empty_at(x0, y0)) return;
    RayLanes rays;
    aim(world_, x0, y0, rays);
    for (int n = 0; n < kLanes; ++n) {
      rays.begin[n] = 0;
      rays.end[n] = std::numeric_limits<float>::infinity();
      if (nearest.hit >> n & 1) {  // as a float that is not before it
        rays.end[n] = std::nextafter(static_cast<float>(nearest.t[n]), rays.end[n]);
      }
    }
    std::uint32_t triangle[kLanes];
    const std::uint32_t met = seen.view.triangles(rays, pixels_inside(x0, y0), x0, y0, triangle);
    if (met == 0) return;
    MeshPointLanes points;
    find_mesh_points(*seen.mesh, rays, triangle, met, points);
    nearest.add(points, triangle, number);
  }

  std::uint32_t pixels_inside(int x0, int y0) const {
    if (x0 + 8 <= width_ && y0 + 4 <= height_) return ~0u;
    std::uint32_t lanes = 0;
    for (int n = 0; n < kLanes; ++n) {
      if (x0 + RayPacket::x_of(n) < width_ && y0 + RayPacket::y_of(n) < height_) lanes |= 1u << n;
    }
    return lanes;
  }

  // From the fan's t to mm.
  void finish(const Half& half, PacketHits& hits) const {
    RayPacket rays;
    aim(world_, half.x0, half.y0, rays);
    for (std::uint32_t rest = measure(rays, hits); rest != 0; rest &= rest - 1) {
      const int n = std::countr_zero(rest);
      hits.face(n, rays.ray(n).direction);
    }
  }

  int width_, height_;
  RayFan world_;
  std::vector<std::variant<IsoView, SeenMesh>> views_;
};

RayCaster::RayCaster(const Scene& scene, const RayCaster* previous)
    : scene_(scene), surfaces_(scene, previous ? &previous->surfaces_ : nullptr) {}

SurfaceBuffer RayCaster::cast(const Camera& camera, const ProgressListener& listener) const {
  SurfaceBuffer buffer(camera.width(), camera.height());
  cast(camera, buffer, listener);
  return buffer;
}

void RayCaster::cast(const Camera& camera, SurfaceBuffer& buffer,
                     const ProgressListener& listener) const {
  const Eye eye(surfaces_, scene_.visibility, camera);
  prepare(buffer);
  std::atomic<std::size_t> further = 0;
  Progress progress(listener, "tracing", static_cast<std::size_t>(buffer.tiles_y()));
  parallel_for(static_cast<std::size_t>(buffer.tiles_y()), 1,
               [&](std::size_t begin, std::size_t end) {
                 const auto tiles_x = static_cast<std::size_t>(buffer.tiles_x());
                 for (std::size_t tile = begin * tiles_x; tile < end * tiles_x;) {
                   const std::size_t next = std::min(tile + kHalvesAtOnce / 2, end * tiles_x);
                   cast_tiles(eye, tile, next, buffer);
                   for (; tile < next; ++tile) {
                     if (!buffer.further.empty()) further += buffer.further[tile].capacity();
                   }
                 }
                 // Layers of noise may be many.
                 check_memory(static_cast<double>(further * sizeof(FurtherPoint)),
                              "what lies behind translucent surfaces and in mirrors");
                 progress.advance(end - begin);
               });
}

PixelView RayCaster::cast_around(const Camera& camera, int x, int y) const {
  PixelView view{SurfaceBuffer(SurfaceBuffer::kTile, SurfaceBuffer::kTile), false};
  SurfaceBuffer& buffer = view.buffer;
  buffer.first_x = x - x % SurfaceBuffer::kTile;
  buffer.first_y = y - y % SurfaceBuffer::kTile;
  prepare(buffer);
  const std::uint64_t turned = cast_tiles(Eye(surfaces_, scene_.visibility, camera), 0, 1, buffer);
  view.turned = (turned >> buffer.at(x - buffer.first_x, y - buffer.first_y) & 1) != 0;
  return view;
}

void RayCaster::prepare(SurfaceBuffer& buffer) const {
  const bool has_meshes =
      std::ranges::any_of(surfaces_.all(), [](const auto& surface) { return surface.mesh(); });
  buffer.points.resize(has_meshes ? buffer.pixels() : 0);
  buffer.further.clear();
  buffer.further.resize(has_further_points(scene_) ? buffer.hits.size() : 0);
}

std::uint64_t RayCaster::cast_tiles(const Eye& eye, std::size_t begin, std::size_t end,
                                    SurfaceBuffer& buffer) const {
  const auto tiles_x = static_cast<std::size_t>(buffer.tiles_x());
  std::array<Eye::Half, kHalvesAtOnce> halves;
  std::size_t count = 0;
  for (std::size_t tile = begin; tile < end; ++tile) {
    buffer.hits[tile] = 0;
    const int x0 = buffer.first_x + static_cast<int>(8 * (tile % tiles_x));
    const int y0 = buffer.first_y + static_cast<int>(8 * (tile / tiles_x));
    for (const int lower : {0, 1}) {
      const Eye::Half half{64 * tile + 32 * static_cast<std::size_t>(lower), x0, y0 + 4 * lower};
      if (eye.sees(half.y0) && eye.may_meet(half.x0, half.y0)) halves[count++] = half;
    }
  }
  std::array<PacketHits, kHalvesAtOnce> found;
  eye.trace(std::span(halves).first(count), std::span(found).first(count));
  std::uint64_t turned_in_first = 0;
  for (std::size_t h = 0; h < count; ++h) {
    const PacketHits& hits = found[h];
    if (hits.hit == 0) continue;
    const std::size_t at = halves[h].place, tile = at / 64;
    buffer.hits[tile] |= std::uint64_t{hits.hit} << at % 64;
    if (tile == begin) turned_in_first |= std::uint64_t{hits.turned} << at % 64;
    std::copy_n(hits.t, kLanes, buffer.depth_mm.data() + at);
    std::copy_n(hits.normal[0], kLanes, buffer.normal_x.data() + at);
    std::copy_n(hits.normal[1], kLanes, buffer.normal_y.data() + at);
    std::copy_n(hits.normal[2], kLanes, buffer.normal_z.data() + at);
    std::copy_n(hits.surface, kLanes, buffer.surface.data() + at);
    if (!buffer.points.empty()) std::copy_n(hits.point, kLanes, buffer.points.data() + at);
    if (buffer.further.empty()) continue;
    FurtherPointFinder(scene_, surfaces_)
        .find(eye.rays(halves[h]), hits, static_cast<std::uint8_t>(at % 64), buffer.further[tile]);
  }
  return turned_in_first;
}

}  // namespace isolux
