#include "isolux/render/ray_caster.h"

#include <algorithm>
#include <atomic>
#include <bit>
#include <cmath>
#include <limits>
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

// Rays this many cells apart pass through the volume more quickly each for itself.
constexpr double kBeamCells = 0.6;

}  // namespace

// What one camera sees of a caster's surfaces.
class RayCaster::Eye {
 public:
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

  // The 8 x 4 pixels from (x0, y0): the upper or lower half of a tile.
  PacketHits trace(int x0, int y0) const {
    PacketHits nearest;
    const std::uint32_t inside = pixels_inside(x0, y0);
    for (std::size_t n = 0; n < views_.size(); ++n) {
      const auto number = static_cast<std::int32_t>(n);
      if (const auto* iso = std::get_if<IsoView>(&views_[n])) {
        trace_iso(*iso, number, x0, y0, inside, nearest);
      } else {
        trace_mesh(std::get<SeenMesh>(views_[n]), number, x0, y0, inside, nearest);
      }
    }
    if (nearest.hit != 0) finish(x0, y0, nearest);
    return nearest;
  }

  // Their rays, of unit direction.
  RayPacket rays(int x0, int y0) const {
    RayPacket packet;
    for (int n = 0; n < kLanes; ++n) {
      Ray ray = world_.ray(x0 + RayPacket::x_of(n), y0 + RayPacket::y_of(n));
      ray.direction = normalize(ray.direction);
      packet.set(n, ray);
    }
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

  void trace_iso(const IsoView& view, std::int32_t number, int x0, int y0, std::uint32_t inside,
                 PacketHits& nearest) const {
    RayLanes rays;
    HitLanes hits;
    std::uint32_t lanes = 0;
    float nearest_t = std::numeric_limits<float>::infinity();
    const unsigned blocks = view.blocks(x0, y0, width_);
    for (int block = 0; block < 2; ++block) {
      if (!(blocks >> block & 1)) continue;
      const std::size_t at = view.bounds.at(x0 + 4 * block, y0);
      lanes |= 0xFFFFu << (16 * block);
      nearest_t = std::min(nearest_t, view.bounds.near[at]);
      std::fill_n(rays.begin + 16 * block, 16, view.bounds.near[at]);
      std::fill_n(rays.end + 16 * block, 16, view.bounds.far[at]);
    }
    if ((lanes & inside) == 0) return;
    aim(view.fan, x0, y0, rays);
    rays.is_beam = view.cells_apart(nearest_t) < kBeamCells;
    view.lanes->first_hits(rays, lanes & inside, hits);
    nearest.add(hits, number);
  }

  void trace_mesh(const SeenMesh& seen, std::int32_t number, int x0, int y0, std::uint32_t inside,
                  PacketHits& nearest) const {
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
    const std::uint32_t met = seen.view.triangles(rays, inside, x0, y0, triangle);
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
  void finish(int x0, int y0, PacketHits& hits) const {
    RayPacket rays;
    aim(world_, x0, y0, rays);
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
                 for (std::size_t tile = begin * tiles_x; tile < end * tiles_x; ++tile) {
                   cast_tile(eye, tile, buffer);
                   if (!buffer.further.empty()) further += buffer.further[tile].capacity();
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
  const std::uint64_t turned = cast_tile(Eye(surfaces_, scene_.visibility, camera), 0, buffer);
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

std::uint64_t RayCaster::cast_tile(const Eye& eye, std::size_t tile, SurfaceBuffer& buffer) const {
  const auto tiles_x = static_cast<std::size_t>(buffer.tiles_x());
  const int x0 = buffer.first_x + static_cast<int>(8 * (tile % tiles_x));
  const int y0 = buffer.first_y + static_cast<int>(8 * (tile / tiles_x));
  std::uint64_t turned = 0;
  buffer.hits[tile] = 0;
  for (std::size_t half = 0; half < 2; ++half) {
    const int y = y0 + static_cast<int>(4 * half);
    if (!eye.sees(y) || !eye.may_meet(x0, y)) continue;
    const PacketHits hits = eye.trace(x0, y);
    if (hits.hit == 0) continue;
    buffer.hits[tile] |= std::uint64_t{hits.hit} << (32 * half);
    turned |= std::uint64_t{hits.turned} << (32 * half);
    const std::size_t at = 64 * tile + 32 * half;
    std::copy_n(hits.t, kLanes, buffer.depth_mm.data() + at);
    std::copy_n(hits.normal[0], kLanes, buffer.normal_x.data() + at);
    std::copy_n(hits.normal[1], kLanes, buffer.normal_y.data() + at);
    std::copy_n(hits.normal[2], kLanes, buffer.normal_z.data() + at);
    std::copy_n(hits.surface, kLanes, buffer.surface.data() + at);
    if (!buffer.points.empty()) std::copy_n(hits.point, kLanes, buffer.points.data() + at);
    if (buffer.further.empty()) continue;
    FurtherPointFinder(scene_, surfaces_)
        .find(eye.rays(x0, y), hits, static_cast<std::uint8_t>(32 * half), buffer.further[tile]);
  }
  return turned;
}

}  // namespace isolux
