#include "isolux/render/path_tracer.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <iterator>
#include <limits>
#include <span>

#include "isolux/base/parallel.h"
#include "isolux/base/sobol.h"
#include "isolux/render/cosine_direction.h"
#include "isolux/render/shadows.h"

namespace isolux {
namespace {

constexpr std::size_t kLanes = RayPacket::kCount;
constexpr std::size_t kPackets = IsoLanes::kPacketsAtOnce;
// Whose paths go together: enough to fill packets, few enough to stay in a core's cache.
constexpr std::uint32_t kPointsAtOnce = 16;

// A point with a normal, from which a path goes on.
struct Vertex {
  Vec3 position;
  Vec3 normal;     // as shaded, on the side the path came from
  Vec3 to_eye;     // back along the ray that met it
  double came_mm;  // length of that ray
  std::int32_t surface;
  MeshPoint point;
};

struct Path {
  Vertex at;
  Ray ray;  // on from there
  Rgb throughput{1, 1, 1};
  std::uint32_t seed = 0;
  std::uint32_t sample = 0;
  std::uint32_t origin = 0;  // number of the point that it belongs to
  std::uint32_t passed = 0;  // translucent surfaces since `at`
};

double mean(Rgb c) { return (c.r + c.g + c.b) / 3; }

}  // namespace

// The paths of a few points at a time.
class PathTracer::Tile {
 public:
  Tile(const PathTracer& tracer, std::vector<PathSum>& sums)
      : scene_(tracer.scene_),
        surfaces_(tracer.surfaces_),
        shadows_(tracer.scene_, tracer.surfaces_),
        has_sky_(!tracer.scene_.has_default_ambient),
        sums_(sums) {}

  // Samples [first, first + count) of a point; `sum`: its place in `sums`.
  void start(const Vertex& vertex, std::uint32_t seed, std::uint32_t sum, int first, int count) {
    for (int n = 0; n < count; ++n) {
      Path& path = paths_.emplace_back();
      path.at = vertex;
      path.seed = seed;
      path.sample = static_cast<std::uint32_t>(first + n);
      path.origin = sum;
    }
  }

  void run() {
    // An estimate for each path, so that they can be added up in their order.
    estimates_.assign(paths_.size(), {});
    std::vector<std::uint32_t> going(paths_.size());
    for (std::uint32_t n = 0; n < going.size(); ++n) going[n] = n;
    for (int bounce = 1; bounce <= scene_.bounces && !going.empty(); ++bounce) {
      for (const std::uint32_t n : going) aim(paths_[n], bounce);
      going = bounced(going, bounce);
    }
    for (std::size_t n = 0; n < paths_.size(); ++n) {
      PathSum& sum = sums_[paths_[n].origin];
      sum.radiance = sum.radiance + estimates_[n];
      sum.square += mean(estimates_[n]) * mean(estimates_[n]);
    }
    paths_.clear();
  }

 private:
  void aim(Path& path, int bounce) {
    const Vertex& at = path.at;
    const PreparedSurface& own = surfaces_.at(at.surface);
    Vec3 onward = cosine_direction(at.normal, sobol_point(path.sample, dimension(path, bounce, 0)));
    if (const auto true_normal = own.true_normal(at.position, at.point)) {
      const double down = dot(onward, *true_normal);
      if (down * dot(at.to_eye, *true_normal) < 0) onward = onward - 2 * down * *true_normal;
    }
    const double back = std::min(own.step_mm(), at.came_mm / 2);
    path.ray = {at.position + back * at.to_eye, onward};
    path.passed = 0;
  }

  static std::uint32_t dimension(const Path& path, int bounce, std::uint32_t which) {
    return mixed(path.seed, static_cast<std::uint32_t>(bounce) << 8 | which);
  }

  // Traces the paths `going` to what they meet, adds the light there, and returns those that go on.
  std::vector<std::uint32_t> bounced(const std::vector<std::uint32_t>& going, int bounce) {
    std::vector<std::uint32_t> onward, passing = going, next;
    while (!passing.empty()) {
      next.clear();
      for (std::size_t first = 0; first < passing.size(); first += kPackets * kLanes) {
        const std::size_t count = std::min(kPackets * kLanes, passing.size() - first);
        trace({passing.data() + first, count}, bounce, onward, next);
      }
      passing.swap(next);
    }
    std::ranges::sort(onward);
    return onward;
  }

  void trace(std::span<const std::uint32_t> numbers, int bounce, std::vector<std::uint32_t>& onward,
             std::vector<std::uint32_t>& passing) {
    const std::size_t packets = (numbers.size() + kLanes - 1) / kLanes;
    std::array<RayPacket, kPackets> rays;
    std::fill_n(rays.begin(), packets, RayPacket{});
    std::array<std::uint32_t, kPackets> lanes{};
    for (std::size_t n = 0; n < packets * kLanes; ++n) {
      RayPacket& packet = rays[n / kLanes];
      const auto number = numbers[std::min(n, numbers.size() - 1)];
      packet.set(static_cast<int>(n % kLanes), paths_[number].ray);
      packet.end[n % kLanes] = std::numeric_limits<float>::infinity();
      if (n < numbers.size()) lanes[n / kLanes] |= 1u << n % kLanes;
    }
    std::array<PacketHits, kPackets> hits;
    first_hits(std::span(rays).first(packets), lanes, hits);
    std::array<PointPacket, kPackets> points;
    std::array<std::uint32_t, kPackets> lit;
    for (std::size_t p = 0; p < packets; ++p) {
      const auto of_packet =
          numbers.subspan(p * kLanes, std::min(kLanes, numbers.size() - p * kLanes));
      start_again(of_packet, lanes[p], rays[p], hits[p]);
      lit[p] = arrive(of_packet, hits[p], bounce, points[p], onward, passing);
    }
    light(numbers, std::span(points).first(packets), lit);
  }

  // Takes the paths of a packet to what they have met, as points; returns the lanes of those that
  // may be lit.
  std::uint32_t arrive(std::span<const std::uint32_t> numbers, PacketHits& hits, int bounce,
                       PointPacket& points, std::vector<std::uint32_t>& onward,
                       std::vector<std::uint32_t>& passing) {
    std::uint32_t lit = 0;
    for (std::size_t lane = 0; lane < numbers.size(); ++lane) {
      const int n = static_cast<int>(lane);
      Path& path = paths_[numbers[lane]];
      if (!(hits.hit >> n & 1)) {
        if (bounce == 1) ++sums_[path.origin].open;
        if (has_sky_) add(numbers[lane], path.throughput * scene_.ambient);
        continue;
      }
      hits.face(n, path.ray.direction);
      if (passes(path, hits, n, bounce)) {
        passing.push_back(numbers[lane]);
        continue;
      }
      path.at = {path.ray.at(hits.t[n]), {hits.normal[0][n], hits.normal[1][n], hits.normal[2][n]},
                 -path.ray.direction,    hits.t[n],
                 hits.surface[n],        hits.point[n]};
      path.throughput = path.throughput * material(path.at).kd;
      if (path.throughput == Rgb{}) continue;
      points.position[n] = path.at.position;
      points.normal[n] = path.at.normal;
      points.to_eye[n] = path.at.to_eye;
      points.came_mm[n] = path.at.came_mm;
      points.surface[n] = path.at.surface;
      points.point[n] = path.at.point;
      lit |= 1u << n;
      if (bounce < scene_.bounces) onward.push_back(numbers[lane]);
    }
    return lit;
  }

  void first_hits(std::span<const RayPacket> rays, std::span<const std::uint32_t> lanes,
                  std::span<PacketHits> hits) const {
    for (std::size_t s = 0; s < surfaces_.all().size(); ++s) {
      surfaces_.all()[s].first_hits(rays, lanes, static_cast<std::int32_t>(s), hits);
    }
  }

  // Where a ray has met the very place that it left, the start was not on the right side of it, by
  // the rounding of floats: such rays go again from where doubles say.
  void start_again(std::span<const std::uint32_t> numbers, std::uint32_t lanes, RayPacket& rays,
                   PacketHits& hits) {
    constexpr double kClose = 100;  // steps
    std::uint32_t again = 0;
    for (std::uint32_t rest = lanes & hits.hit; rest != 0; rest &= rest - 1) {
      const int n = std::countr_zero(rest);
      Path& path = paths_[numbers[static_cast<std::size_t>(n)]];
      const PreparedSurface& own = surfaces_.at(path.at.surface);
      if (path.passed > 0 || hits.surface[n] != path.at.surface ||
          hits.t[n] > kClose * own.step_mm()) {
        continue;
      }
      const Ray came{path.at.position + path.at.came_mm * path.at.to_eye, -path.at.to_eye};
      path.ray.origin = came.at(own.t_before(came, path.at.came_mm));
      rays.set(n, path.ray);
      again |= 1u << n;
    }
    if (again == 0) return;
    hits.hit &= ~again;
    first_hits({&rays, 1}, {&again, 1}, {&hits, 1});
  }

  // Whether the path goes through the translucent surface that it has met.
  bool passes(Path& path, const PacketHits& hits, int n, int bounce) {
    const auto surface = static_cast<std::size_t>(hits.surface[n]);
    const double opacity = scene_.surfaces[surface].material.opacity;
    if (opacity == 1) return false;
    const double drawn = sobol_point(path.sample, dimension(path, bounce, 1 + path.passed)).u;
    if (drawn < opacity) return false;
    ++path.passed;
    const double beyond = hits.t[n] + kBeyond * surfaces_.at(hits.surface[n]).step_mm();
    path.ray.origin = path.ray.at(beyond);
    return true;
  }

  void light(std::span<const std::uint32_t> numbers, std::span<const PointPacket> points,
             std::span<const std::uint32_t> lit) {
    std::array<ShadowQuestion, kPackets> questions;
    for (const Light& lamp : scene_.lights) {
      for (std::size_t p = 0; p < points.size(); ++p) {
        questions[p] = {&points[p], lit[p], {}, {}};
        std::ranges::fill(questions[p].share, 1.0f);
      }
      if (scene_.shadows) shadows_.reach(lamp, std::span(questions).first(points.size()));
      for (std::size_t p = 0; p < points.size(); ++p) {
        for (std::uint32_t rest = lit[p]; rest != 0; rest &= rest - 1) {
          const auto n = static_cast<std::size_t>(std::countr_zero(rest));
          const float share = questions[p].share[n];
          if (share == 0) continue;
          const std::uint32_t number = numbers[p * kLanes + n];
          const Rgb arriving =
              irradiance(lamp, {points[p].position[n], points[p].normal[n], points[p].to_eye[n]});
          add(number, static_cast<double>(share) * (paths_[number].throughput * arriving));
        }
      }
    }
  }

  void add(std::uint32_t number, Rgb radiance) {
    estimates_[number] = estimates_[number] + radiance;
  }

  Material material(const Vertex& at) const {
    return material_at(scene_.surfaces[static_cast<std::size_t>(at.surface)], at.point);
  }

  // Far enough not to meet the same crossing again.
  static constexpr double kBeyond = 100;

  const Scene& scene_;
  const SceneSurfaces& surfaces_;
  ShadowRays shadows_;
  bool has_sky_;
  std::vector<PathSum>& sums_;
  std::vector<Path> paths_;
  std::vector<Rgb> estimates_;
};

namespace {

Vertex vertex_of(const Scene& scene, const SurfaceBuffer& buffer, std::size_t place) {
  const auto [x, y] = buffer.pixel(place);
  const SurfaceSample sample = buffer.sample(place);
  const Ray ray = scene.camera->ray(x, y);
  return {ray.at(sample.depth_mm), sample.normal(), -ray.direction,
          sample.depth_mm,         sample.surface,  sample.point};
}

Vertex vertex_of(const FurtherPoint& point) {
  const SurfacePoint at = point_of(point);
  return {at.position, at.normal, at.to_eye, point.came_mm, point.surface, point.point};
}

// Keys the random numbers of a pixel, or of its further points.
std::uint32_t seed_of(const Scene& scene, const SurfaceBuffer& buffer, std::size_t place,
                      std::uint32_t further) {
  const auto [x, y] = buffer.pixel(place);
  const std::uint32_t scenes =
      mixed(static_cast<std::uint32_t>(scene.seed), static_cast<std::uint32_t>(scene.seed >> 32));
  return mixed(mixed(mixed(scenes, static_cast<std::uint32_t>(x)), static_cast<std::uint32_t>(y)),
               further);
}

}  // namespace

PathTracer::PathTracer(const Scene& scene, const SceneSurfaces& surfaces)
    : scene_(scene), surfaces_(surfaces) {}

void PathTracer::add_samples(const SurfaceBuffer& buffer, int first, int count,
                             const ProgressListener& listener) {
  const std::size_t tiles = buffer.hits.size();
  pixels_.resize(buffer.pixels());
  further_.resize(buffer.further.size());
  Progress progress(listener, "following light", tiles);
  parallel_for(tiles, 4, [&](std::size_t begin, std::size_t end) {
    for (std::size_t t = begin; t < end; ++t) {
      std::vector<PathSum> sums(SurfaceBuffer::kTilePixels);
      std::copy_n(pixels_.begin() + static_cast<std::ptrdiff_t>(64 * t), 64, sums.begin());
      Tile tile(*this, sums);
      std::uint32_t started = 0;
      const auto start = [&](const Vertex& vertex, std::uint32_t seed, std::uint32_t sum) {
        tile.start(vertex, seed, sum, first, count);
        if (++started % kPointsAtOnce == 0) tile.run();
      };
      for (std::uint64_t rest = buffer.hits[t]; rest != 0; rest &= rest - 1) {
        const auto n = static_cast<std::uint32_t>(std::countr_zero(rest));
        start(vertex_of(scene_, buffer, 64 * t + n), seed_of(scene_, buffer, 64 * t + n, 0), n);
      }
      if (!buffer.further.empty()) {
        const FurtherPoints& points = buffer.further[t];
        further_[t].resize(points.size());
        std::ranges::copy(further_[t], std::back_inserter(sums));
        for (std::uint32_t n = 0; n < points.size(); ++n) {
          if (points[n].surface == FurtherPoint::kBackground) continue;
          start(vertex_of(points[n]), seed_of(scene_, buffer, 64 * t + points[n].pixel, n + 1),
                SurfaceBuffer::kTilePixels + n);
        }
      }
      tile.run();
      std::copy_n(sums.begin(), 64, pixels_.begin() + static_cast<std::ptrdiff_t>(64 * t));
      if (!buffer.further.empty()) std::copy(sums.begin() + 64, sums.end(), further_[t].begin());
    }
    progress.advance(end - begin);
  });
  samples_ = first + count;
}

void PathTracer::run(const SurfaceBuffer& buffer, const ProgressListener& listener) {
  if (!scene_.indirect_error) {
    add_samples(buffer, 0, scene_.spp, listener);
    return;
  }
  // Twice as many each time: so the error is looked at rarely, and at whole sets of Sobol points.
  constexpr int kFirst = 16;
  int count = std::min(kFirst, scene_.spp);
  do {
    add_samples(buffer, samples_, count, listener);
    count = std::min(samples_, scene_.spp - samples_);
  } while (count > 0 && relative_error() > *scene_.indirect_error);
}

double PathTracer::relative_error() const {
  double variance = 0, total = 0;
  std::size_t points = 0;
  for (const PathSum& sum : pixels_) {
    if (sum.square == 0) continue;
    const double average = mean(sum.radiance) / samples_;
    variance += std::max(0.0, sum.square / samples_ - average * average) / samples_;
    total += average;
    ++points;
  }
  if (total == 0) return 0;
  return std::sqrt(variance / static_cast<double>(points)) / (total / static_cast<double>(points));
}

std::vector<float> PathTracer::variances() const {
  std::vector<float> variances;
  if (samples_ < 2) return variances;
  for (const PathSum& sum : pixels_) {
    const double average = mean(sum.radiance) / samples_;
    const double off = std::max(0.0, sum.square / samples_ - average * average);
    variances.push_back(static_cast<float>(off / (samples_ - 1)));
  }
  return variances;
}

Indirect PathTracer::indirect(const SurfaceBuffer& buffer) const {
  Indirect result{RgbLayer(buffer.pixels()), {}, std::vector<float>(buffer.pixels())};
  const double share = 1.0 / samples_;
  for (std::size_t place = 0; place < pixels_.size(); ++place) {
    result.pixels.set(place, share * pixels_[place].radiance);
    result.sky[place] = static_cast<float>(share * pixels_[place].open);
  }
  for (const std::vector<PathSum>& of_tile : further_) {
    auto& to = result.further.emplace_back();
    for (const PathSum& sum : of_tile) {
      const Rgb e = share * sum.radiance;
      to.push_back({static_cast<float>(e.r), static_cast<float>(e.g), static_cast<float>(e.b)});
    }
  }
  return result;
}

}  // namespace isolux
