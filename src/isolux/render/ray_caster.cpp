#include "isolux/render/ray_caster.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>
#include <variant>

#include "isolux/base/parallel.h"
#include "isolux/intersect/mesh_points.h"
#include "isolux/mesh/extract_isosurface.h"
#include "isolux/render/mesh_view.h"
#include "isolux/render/tile_bounds.h"

namespace isolux {
namespace {

constexpr int kLanes = RayLanes::kCount;
static_assert(kLanes == 2 * SurfaceBuffer::kBlockPixels);

// A lane's pixel in two blocks side by side.
constexpr int lane_x(int n) { return (n & 3) + (n >> 4 << 2); }
constexpr int lane_y(int n) { return n >> 2 & 3; }

// The nearest hits of some pixels, with t as the fan counts it.
struct PixelHits {
  std::uint32_t hit = 0;
  std::uint32_t turned = 0;
  double t[kLanes];
  float normal[3][kLanes];
  std::int32_t surface[kLanes];
  MeshPoint point[kLanes];

  void add(const HitLanes& hits, std::int32_t number) {
    for (std::uint32_t rest = hits.hit; rest != 0; rest &= rest - 1) {
      const int n = std::countr_zero(rest);
      if (!is_nearer(n, hits.t[n])) continue;
      set(n, hits, number);
      point[n] = {};
    }
  }
  void add(const MeshPointLanes& points, const std::uint32_t* triangle, std::int32_t number) {
    for (std::uint32_t rest = points.met; rest != 0; rest &= rest - 1) {
      const int n = std::countr_zero(rest);
      if (is_nearer(n, points.t[n])) {
        set(n, points, number);
        point[n] = {triangle[n], points.u[n], points.v[n]};
      }
    }
  }

 private:
  bool is_nearer(int n, double there) const { return !(hit >> n & 1) || there < t[n]; }

  // What lane n has met, in lanes of one kind or the other.
  template <typename Lanes>
  void set(int n, const Lanes& from, std::int32_t number) {
    const std::uint32_t bit = 1u << n;
    hit |= bit;
    turned = (turned & ~bit) | (from.away & bit);
    t[n] = from.t[n];
    surface[n] = number;
    for (int axis = 0; axis < 3; ++axis) {
      normal[axis][n] = from.away & bit ? -from.normal[axis][n] : from.normal[axis][n];
    }
  }
};

}  // namespace

// What one camera sees of a caster's surfaces.
class RayCaster::Eye {
 public:
  Eye(const std::vector<Prepared>& surfaces, const Camera& camera)
      : width_(camera.width()), height_(camera.height()), world_(camera.fan()) {
    for (const Prepared& surface : surfaces) {
      if (surface.lanes) {
        views_.emplace_back(IsoView(*surface.lanes, world_, camera));
      } else {
        views_.emplace_back(surface.tree ? SeenMesh{surface.mesh, {surface.tree, camera}}
                                         : SeenMesh{surface.mesh, {*surface.mesh, camera}});
      }
    }
  }

  // The 8 x 4 pixels from (x0, y0): the upper or lower half of a tile.
  PixelHits trace(int x0, int y0) const {
    PixelHits nearest;
    const std::uint32_t inside = pixels_inside(x0, y0);
    for (std::size_t n = 0; n < views_.size(); ++n) {
      const auto number = static_cast<std::int32_t>(n);
      if (const auto* iso = std::get_if<IsoView>(&views_[n])) {
        trace_iso(*iso, number, x0, y0, inside, nearest);
      } else {
        trace_mesh(std::get<SeenMesh>(views_[n]), number, x0, y0, inside, nearest);
      }
    }
    for (std::uint32_t rest = nearest.hit; rest != 0; rest &= rest - 1) {
      finish(x0, y0, std::countr_zero(rest), nearest);
    }
    return nearest;
  }

 private:
  struct IsoView {
    const IsoLanes* lanes;
    RayFan fan;  // in the index space of the surface's volume
    TileBounds bounds;

    IsoView(const IsoLanes& of, const RayFan& world, const Camera& camera)
        : lanes(&of),
          fan(carried(of.surface().index_from_world(), world)),
          bounds(of.skip(), of.surface().volume().world_from_index, camera, SurfaceBuffer::kBlock) {
    }
  };
  struct SeenMesh {
    std::shared_ptr<const Mesh> mesh;
    MeshView view;
  };

  void trace_iso(const IsoView& view, std::int32_t number, int x0, int y0, std::uint32_t inside,
                 PixelHits& nearest) const {
    RayLanes rays;
    HitLanes hits;
    std::uint32_t lanes = 0;
    for (int block = 0; block < 2 && x0 + 4 * block < width_; ++block) {
      const std::size_t at = view.bounds.at(x0 + 4 * block, y0);
      if (view.bounds.near[at] > view.bounds.far[at]) continue;
      lanes |= 0xFFFFu << (16 * block);
      std::fill_n(rays.begin + 16 * block, 16, view.bounds.near[at]);
      std::fill_n(rays.end + 16 * block, 16, view.bounds.far[at]);
    }
    if ((lanes & inside) == 0) return;
    set_rays(view.fan, x0, y0, rays);
    view.lanes->first_hits(rays, lanes & inside, hits);
    nearest.add(hits, number);
  }

  void trace_mesh(const SeenMesh& seen, std::int32_t number, int x0, int y0, std::uint32_t inside,
                  PixelHits& nearest) const {
    int x[kLanes], y[kLanes];
    for (int n = 0; n < kLanes; ++n) {
      x[n] = x0 + lane_x(n);
      y[n] = y0 + lane_y(n);
    }
    const std::uint32_t wanted = inside & seen.view.possible(x, y);
    if (wanted == 0) return;
    RayLanes rays;
    set_rays(world_, x0, y0, rays);
    for (int n = 0; n < kLanes; ++n) {
      rays.begin[n] = 0;
      rays.end[n] = std::numeric_limits<float>::infinity();
      if (nearest.hit >> n & 1) {  // as a float that is not before it
        rays.end[n] = std::nextafter(static_cast<float>(nearest.t[n]), rays.end[n]);
      }
    }
    std::uint32_t triangle[kLanes];
    const std::uint32_t met = seen.view.triangles(rays, wanted, x, y, triangle);
    if (met == 0) return;
    MeshPointLanes points;
    find_mesh_points(*seen.mesh, rays, triangle, met, points);
    nearest.add(points, triangle, number);
  }

  static void set_rays(const RayFan& fan, int x0, int y0, RayLanes& rays) {
    for (int axis = 0; axis < 3; ++axis) {
      const auto fill = [&](const RayFan::Plane& plane, double* out) {
        const double step_x = plane.along_x[axis], step_y = plane.along_y[axis];
        for (int n = 0; n < kLanes; ++n) {
          out[n] = plane.first[axis] + (x0 + lane_x(n)) * step_x + (y0 + lane_y(n)) * step_y;
        }
      };
      fill(fan.origin, rays.origin[axis]);
      fill(fan.direction, rays.direction[axis]);
    }
  }

  std::uint32_t pixels_inside(int x0, int y0) const {
    if (x0 + 8 <= width_ && y0 + 4 <= height_) return ~0u;
    std::uint32_t lanes = 0;
    for (int n = 0; n < kLanes; ++n) {
      if (x0 + lane_x(n) < width_ && y0 + lane_y(n) < height_) lanes |= 1u << n;
    }
    return lanes;
  }

  // From the fan's t to mm; and where the surface has no normal, it faces the eye.
  void finish(int x0, int y0, int n, PixelHits& hits) const {
    const Vec3 direction = world_.direction.at(x0 + lane_x(n), y0 + lane_y(n));
    const double scale = length(direction);
    hits.t[n] *= scale;
    auto& [nx, ny, nz] = hits.normal;
    if (nx[n] != 0 || ny[n] != 0 || nz[n] != 0) return;
    nx[n] = static_cast<float>(-direction.x / scale);
    ny[n] = static_cast<float>(-direction.y / scale);
    nz[n] = static_cast<float>(-direction.z / scale);
  }

  int width_, height_;
  RayFan world_;
  std::vector<std::variant<IsoView, SeenMesh>> views_;
};

RayCaster::Prepared RayCaster::prepared(const SurfaceItem& item, Visibility visibility,
                                        const RayCaster* previous) {
  // Made once, by this caster or by the one before.
  const auto kept = [&](auto RayCaster::*map, const auto& key, const auto& make) {
    auto& value = (this->*map)[key];
    if (!value && previous && (previous->*map).contains(key)) value = (previous->*map).at(key);
    if (!value) value = make();
    return value;
  };
  const VolumeAndIso key{item.volume, item.iso};
  if (visibility == Visibility::kRaster) {
    if (item.mesh) return {.lanes = nullptr, .mesh = item.mesh, .tree = nullptr};
    const auto extracted = kept(&RayCaster::meshes_, key, [&] {
      return std::make_shared<const Mesh>(extract_isosurface(*item.volume, item.iso));
    });
    return {.lanes = nullptr, .mesh = extracted, .tree = nullptr};
  }
  if (item.mesh) {
    const auto tree = kept(&RayCaster::trees_, item.mesh,
                           [&] { return std::make_shared<const MeshSurface>(item.mesh); });
    return {.lanes = nullptr, .mesh = item.mesh, .tree = tree};
  }
  const auto bricks = kept(&RayCaster::bricks_, item.volume,
                           [&] { return std::make_shared<const BrickGrid>(*item.volume); });
  const auto lanes = kept(&RayCaster::lanes_, key, [&] {
    return std::make_shared<const IsoLanes>(IsoSurface(item.volume, bricks, item.iso), *bricks);
  });
  return {.lanes = lanes, .mesh = nullptr, .tree = nullptr};
}

RayCaster::RayCaster(const Scene& scene, const RayCaster* previous) {
  for (const SurfaceItem& item : scene.surfaces) {
    surfaces_.push_back(prepared(item, scene.visibility, previous));
    has_painted_ |= item.is_painted;
  }
}

SurfaceBuffer RayCaster::cast(const Camera& camera, const ProgressListener& listener) const {
  SurfaceBuffer buffer(camera.width(), camera.height());
  cast(camera, buffer, listener);
  return buffer;
}

void RayCaster::cast(const Camera& camera, SurfaceBuffer& buffer,
                     const ProgressListener& listener) const {
  const Eye eye(surfaces_, camera);
  buffer.points.resize(has_painted_ ? buffer.pixels() : 0);
  const auto tiles_x = static_cast<std::size_t>(buffer.tiles_x());
  Progress progress(listener, "tracing", static_cast<std::size_t>(buffer.tiles_y()));
  const auto trace_row = [&](std::size_t row) {
    for (std::size_t column = 0; column < tiles_x; ++column) {
      const std::size_t tile = row * tiles_x + column;
      buffer.hits[tile] = 0;
      for (std::size_t half = 0; half < 2; ++half) {
        const int x0 = static_cast<int>(8 * column), y0 = static_cast<int>(8 * row + 4 * half);
        if (y0 >= camera.height()) continue;
        const PixelHits hits = eye.trace(x0, y0);
        if (hits.hit == 0) continue;
        buffer.hits[tile] |= std::uint64_t{hits.hit} << (32 * half);
        const std::size_t at = 64 * tile + 32 * half;
        std::copy_n(hits.t, kLanes, buffer.depth_mm.data() + at);
        std::copy_n(hits.normal[0], kLanes, buffer.normal_x.data() + at);
        std::copy_n(hits.normal[1], kLanes, buffer.normal_y.data() + at);
        std::copy_n(hits.normal[2], kLanes, buffer.normal_z.data() + at);
        std::copy_n(hits.surface, kLanes, buffer.surface.data() + at);
        if (has_painted_) std::copy_n(hits.point, kLanes, buffer.points.data() + at);
      }
    }
  };
  parallel_for(static_cast<std::size_t>(buffer.tiles_y()), 1,
               [&](std::size_t begin, std::size_t end) {
                 for (std::size_t row = begin; row < end; ++row) trace_row(row);
                 progress.advance(end - begin);
               });
}

PixelHit RayCaster::cast_pixel(const Camera& camera, int x, int y) const {
  const Eye eye(surfaces_, camera);
  const PixelHits hits = eye.trace(x & ~7, y & ~3);
  const int n = (x & 4) * 4 + (y & 3) * 4 + (x & 3);
  if (!(hits.hit >> n & 1)) return {};
  return {{hits.t[n], hits.normal[0][n], hits.normal[1][n], hits.normal[2][n], hits.surface[n],
           hits.point[n]},
          (hits.turned >> n & 1) != 0};
}

}  // namespace isolux
