#include "isolux/render/further_points.h"

#include <algorithm>
#include <limits>

#include "isolux/base/error.h"
#include "isolux/render/crossings.h"

namespace isolux {
namespace {

constexpr int kLanes = RayPacket::kCount;

double greatest(Rgb c) { return std::max({c.r, c.g, c.b}); }

template <typename T>
void set(T (&out)[3], Vec3 value) {
  for (int axis = 0; axis < 3; ++axis) out[axis] = static_cast<T>(value[axis]);
}

}  // namespace

// A ray whose radiance counts in a pixel.
struct FurtherPointFinder::Branch {
  std::uint8_t pixel;
  Ray ray;  // of unit direction
  Rgb weight;
  int mirrors = 0;  // that it has met
  // The layer that it has passed already, if any.
  std::int32_t after_surface = FurtherPoint::kBackground;
  double after_t = 0;
  bool after_turned = false;
};

// The crossings of every surface along some branches, one after the other.
class FurtherPointFinder::Layers {
 public:
  Layers(const SceneSurfaces& surfaces, const std::vector<Branch>& branches) {
    RayPacket rays{};
    for (int n = 0; n < kLanes; ++n) {
      rays.set(n, branches[std::min(static_cast<std::size_t>(n), branches.size() - 1)].ray);
      rays.end[n] = std::numeric_limits<float>::infinity();
    }
    for (std::size_t s = 0; s < surfaces.all().size(); ++s) {
      const auto number = static_cast<std::int32_t>(s);
      Crossings& crossings = of_surface_.emplace_back(surfaces.all()[s], number, rays);
      std::uint32_t fresh = 0, passed = 0;
      double from[kLanes];
      for (std::size_t n = 0; n < branches.size(); ++n) {
        const Branch& branch = branches[n];
        const bool has_passed = branch.after_surface == number;
        if (has_passed) {
          crossings.set_crossed(static_cast<int>(n), branch.after_t, branch.after_turned);
        }
        (has_passed ? passed : fresh) |= 1u << n;
        from[n] = std::max(0.0, branch.after_t - surfaces.all()[s].step_mm());
      }
      crossings.pass(passed);
      crossings.find(fresh, from);
    }
  }

  // The surface that branch n meets next; kBackground: none. Of two at one place the first.
  std::int32_t nearest(int n) const {
    std::int32_t found = FurtherPoint::kBackground;
    for (std::size_t s = 0; s < of_surface_.size(); ++s) {
      const PacketHits& hits = of_surface_[s].hits();
      if (!(hits.hit >> n & 1)) continue;
      if (found < 0 || hits.t[n] < of(found).t[n]) found = static_cast<std::int32_t>(s);
    }
    return found;
  }
  const PacketHits& of(std::int32_t surface) const {
    return of_surface_[static_cast<std::size_t>(surface)].hits();
  }
  void pass(std::size_t surface, std::uint32_t lanes) { of_surface_[surface].pass(lanes); }

 private:
  std::vector<Crossings> of_surface_;
};

FurtherPointFinder::FurtherPointFinder(const Scene& scene, const SceneSurfaces& surfaces)
    : scene_(scene), surfaces_(surfaces) {}

void FurtherPointFinder::find(const RayPacket& eye_rays, const PacketHits& nearest,
                              std::uint8_t first_pixel, FurtherPoints& points) const {
  std::vector<Branch> branches, mirrored;
  for (std::uint32_t rest = nearest.hit; rest != 0; rest &= rest - 1) {
    const int n = std::countr_zero(rest);
    Branch branch{static_cast<std::uint8_t>(first_pixel + n), eye_rays.ray(n), {1, 1, 1}};
    reflect(branch, nearest, n, mirrored);
    branch.weight = (1 - material(nearest.surface[n]).opacity) * branch.weight;
    if (greatest(branch.weight) < kLeastWeight) continue;
    branch.after_surface = nearest.surface[n];
    branch.after_t = nearest.t[n];
    branch.after_turned = (nearest.turned >> n & 1) != 0;
    branches.push_back(branch);
  }
  follow(branches, points, mirrored);
  while (!mirrored.empty()) {
    branches.swap(mirrored);
    mirrored.clear();
    follow(branches, points, mirrored);
  }
}

const Material& FurtherPointFinder::material(std::int32_t surface) const {
  return scene_.surfaces[static_cast<std::size_t>(surface)].material;
}

void FurtherPointFinder::reflect(const Branch& branch, const PacketHits& hits, int n,
                                 std::vector<Branch>& mirrored) const {
  const Material& of = material(hits.surface[n]);
  const Rgb weight = of.opacity * (of.kr * branch.weight);
  if (branch.mirrors == scene_.mirror_depth || greatest(weight) < kLeastWeight) return;
  const PreparedSurface& surface = surfaces_.at(hits.surface[n]);
  const Vec3 normal{hits.normal[0][n], hits.normal[1][n], hits.normal[2][n]};
  const Vec3 d = branch.ray.direction;
  Vec3 onward = d - 2 * dot(d, normal) * normal;
  if (const auto true_normal = surface.true_normal(branch.ray.at(hits.t[n]), hits.point[n])) {
    const double down = dot(onward, *true_normal);
    if (down * dot(d, *true_normal) > 0) onward = onward - 2 * down * *true_normal;
  }
  const Vec3 start = branch.ray.at(surface.t_before(branch.ray, hits.t[n]));
  mirrored.push_back({branch.pixel, {start, normalize(onward)}, weight, branch.mirrors + 1});
}

void FurtherPointFinder::follow(const std::vector<Branch>& branches, FurtherPoints& points,
                                std::vector<Branch>& mirrored) const {
  for (std::size_t first = 0; first < branches.size(); first += kLanes) {
    const auto count = static_cast<int>(std::min<std::size_t>(kLanes, branches.size() - first));
    std::vector<Branch> packet(branches.begin() + static_cast<std::ptrdiff_t>(first),
                               branches.begin() + static_cast<std::ptrdiff_t>(first) + count);
    Layers layers(surfaces_, packet);
    std::vector<std::uint32_t> passed(surfaces_.all().size());
    for (std::uint32_t active = ~0u >> (kLanes - count); active != 0;) {
      std::ranges::fill(passed, 0);
      for (std::uint32_t rest = active; rest != 0; rest &= rest - 1) {
        const int n = std::countr_zero(rest);
        Branch& branch = packet[static_cast<std::size_t>(n)];
        const std::int32_t number = layers.nearest(n);
        FurtherPoint point{.pixel = branch.pixel, .is_mirrored = branch.mirrors > 0};
        point.surface = number;
        if (number == FurtherPoint::kBackground) {
          set(point.weight, {branch.weight.r, branch.weight.g, branch.weight.b});
          points.push_back(point);
          active &= ~(1u << n);
          continue;
        }
        const PacketHits& hits = layers.of(number);
        const double opacity = material(number).opacity;
        set(point.weight, {branch.weight.r, branch.weight.g, branch.weight.b});
        set(point.normal, {hits.normal[0][n], hits.normal[1][n], hits.normal[2][n]});
        set(point.to_eye, -branch.ray.direction);
        point.came_mm = hits.t[n];
        point.position = branch.ray.at(hits.t[n]);
        point.point = hits.point[n];
        points.push_back(point);
        reflect(branch, hits, n, mirrored);
        branch.weight = (1 - opacity) * branch.weight;
        if (greatest(branch.weight) < kLeastWeight) {
          active &= ~(1u << n);
        } else {
          passed[static_cast<std::size_t>(number)] |= 1u << n;
        }
      }
      if (points.size() + mirrored.size() > kMostAtOnce) {
        throw WorkError("--surface", "mirrors and translucent surfaces show each other too often",
                        "lower --mirror-depth or kr, or raise the opacity");
      }
      for (std::size_t s = 0; s < passed.size(); ++s) {
        layers.pass(s, passed[s]);
      }
    }
  }
}

}  // namespace isolux
