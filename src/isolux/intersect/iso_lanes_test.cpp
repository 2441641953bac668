#include "isolux/intersect/iso_lanes.h"

#include <gtest/gtest.h>

#include <bit>
#include <cmath>
#include <limits>
#include <random>

#include "isolux/volume/phantom.h"

namespace isolux {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();

struct Disagreements {
  int rays = 0;
  int hits = 0;
  int other = 0;        ///< hit by one and not by the other, or in another place
  double residual = 0;  ///< greatest |f - iso| at a hit, over the greatest |voxel - iso|
  double normal = 0;    ///< greatest distance between unit normals
};

void set_ray(RayLanes& rays, int n, const Ray& ray) {
  for (int axis = 0; axis < 3; ++axis) {
    rays.origin[axis][n] = ray.origin[axis];
    rays.direction[axis][n] = ray.direction[axis];
  }
  rays.begin[n] = 0;
  rays.end[n] = std::numeric_limits<float>::infinity();
}

// Shoots rays by both and compares. `next` makes rays in index space.
template <typename NextRay>
Disagreements compare(const Volume& volume, double iso, int packets, NextRay next) {
  const auto shared = std::make_shared<const Volume>(volume);
  const auto bricks = std::make_shared<const BrickGrid>(*shared);
  const IsoSurface oracle(shared, bricks, iso);
  const IsoLanes lanes(IsoSurface(shared, bricks, iso), *bricks);
  double greatest = 0;
  for (const BrickRange& range : bricks->ranges()) {
    greatest = std::max({greatest, std::fabs(range.low - iso), std::fabs(range.high - iso)});
  }
  Disagreements result;
  RayLanes rays;
  HitLanes hits;
  for (int packet = 0; packet < packets; ++packet) {
    Ray ray[RayLanes::kCount];
    for (int n = 0; n < RayLanes::kCount; ++n) {
      ray[n] = next();
      set_ray(rays, n, ray[n]);
    }
    rays.is_beam = packet % 2 == 1;  // both walks, in turn
    lanes.first_hits(rays, ~0u, hits);
    for (int n = 0; n < RayLanes::kCount; ++n) {
      ++result.rays;
      const auto expected = oracle.first_hit_in_index_space(ray[n], kInfinity);
      const bool hit = hits.hit >> n & 1;
      if (hit != expected.has_value()) {
        ++result.other;
        continue;
      }
      if (!hit) continue;
      ++result.hits;
      const double along = length(ray[n].direction) * std::fabs(hits.t[n] - expected->t);
      const Vec3 p = ray[n].at(hits.t[n]);
      CellIndex cell;
      Vec3 local;
      for (int axis = 0; axis < 3; ++axis) {
        cell[axis] = std::clamp(static_cast<int>(std::floor(p[axis])), 0, volume.dims[axis] - 2);
        local[axis] = p[axis] - cell[axis];
      }
      const double value = visit_voxels(
          *shared, [&](const auto& view) { return interpolate(cell_corners(view, cell), local); });
      result.residual = std::max(result.residual, std::fabs(value - iso) / greatest);
      // Two roots of one surface lie further apart than this, or the field between them is flat.
      if (along > 1e-2) ++result.other;
      const Vec3 normal{hits.normal[0][n], hits.normal[1][n], hits.normal[2][n]};
      const double towards = dot(normal, ray[n].direction) / length(ray[n].direction);
      if (towards > 1e-5) ++result.other;
      const double side = hits.turned >> n & 1 ? -1 : 1;
      if (along < 1e-5) {
        result.normal = std::max(result.normal,
                                 length(side * normal - oracle.normal(*expected).value_or(Vec3{})));
      }
    }
  }
  return result;
}

class RandomRays {
 public:
  RandomRays(const std::array<int, 3>& dims, unsigned seed) : dims_(dims), random_(seed) {}

  // From around the volume to a point in it.
  Ray operator()() {
    Vec3 from, to;
    for (int axis = 0; axis < 3; ++axis) {
      const double size = dims_[static_cast<std::size_t>(axis)] - 1;
      from[axis] = size / 2 + 2 * size * (uniform() - 0.5) * 2;
      to[axis] = size * uniform();
    }
    return {from, normalize(to - from)};
  }

  double uniform() { return std::uniform_real_distribution<double>(0, 1)(random_); }
  unsigned integer() { return static_cast<unsigned>(random_()); }

 private:
  std::array<int, 3> dims_;
  std::mt19937 random_;
};

template <typename T>
Volume random_volume(const std::array<int, 3>& dims, unsigned seed, double low, double high) {
  RandomRays random(dims, seed);
  std::vector<T> voxels(static_cast<std::size_t>(dims[0] * dims[1] * dims[2]));
  for (T& voxel : voxels) voxel = static_cast<T>(low + (high - low) * random.uniform());
  Volume volume;
  volume.dims = dims;
  volume.voxels = std::move(voxels);
  return volume;
}

void expect_agreement(const Disagreements& found) {
  EXPECT_EQ(found.other, 0) << "of " << found.rays;
  EXPECT_GT(found.hits, 0);
  EXPECT_LE(found.residual, IsoLanes::kDoubt);
  EXPECT_LT(found.normal, 1e-3);
}

TEST(IsoLanes, agree_with_the_oracle_on_noise_of_every_voxel_type) {
  const std::array<int, 3> dims{19, 23, 17};
  // High thresholds leave isolated peaks: pairs of crossings in one cell.
  expect_agreement(
      compare(random_volume<std::uint8_t>(dims, 1, 0, 256), 240.5, 2000, RandomRays(dims, 11)));
  expect_agreement(
      compare(random_volume<std::int16_t>(dims, 2, -1000, 1000), 930, 2000, RandomRays(dims, 12)));
  expect_agreement(compare(random_volume<std::uint16_t>(dims, 3, 0, 65535), 30000.25, 2000,
                           RandomRays(dims, 13)));
  expect_agreement(compare(random_volume<float>(dims, 4, -1, 1), 0.9, 2000, RandomRays(dims, 14)));
}

TEST(IsoLanes, voxels_out_of_the_gathers_reach_give_the_same_bits) {
  const std::array<int, 3> dims{19, 23, 17};
  const auto same = [&]<typename T>(T low, T high, double iso) {
    const auto volume = std::make_shared<const Volume>(random_volume<T>(dims, 7, low, high));
    const auto bricks = std::make_shared<const BrickGrid>(*volume);
    const IsoSurface surface(volume, bricks, iso);
    const IsoLanes near(surface, *bricks), far(surface, *bricks, 0);
    RandomRays random(dims, 15);
    RayLanes rays;
    for (int packet = 0; packet < 300; ++packet) {
      for (int n = 0; n < RayLanes::kCount; ++n) set_ray(rays, n, random());
      rays.is_beam = packet % 2 == 1;
      HitLanes a, b;
      near.first_hits(rays, ~0u, a);
      far.first_hits(rays, ~0u, b);
      ASSERT_EQ(a.hit, b.hit);
      for (int n = 0; n < RayLanes::kCount; ++n) {
        if (!(a.hit >> n & 1)) continue;
        EXPECT_EQ(a.t[n], b.t[n]);
        for (int axis = 0; axis < 3; ++axis) EXPECT_EQ(a.normal[axis][n], b.normal[axis][n]);
      }
    }
  };
  same(std::uint8_t{0}, std::uint8_t{255}, 200.5);
  same(std::int16_t{-1000}, std::int16_t{1000}, 700);
  same(std::uint16_t{0}, std::uint16_t{60000}, 50000);
  same(-1.0f, 1.0f, 0.7);
}

TEST(IsoLanes, what_one_lane_holds_has_no_influence_on_another) {
  const std::array<int, 3> dims{19, 23, 17};
  const auto volume =
      std::make_shared<const Volume>(random_volume<std::int16_t>(dims, 8, -1000, 1000));
  const auto bricks = std::make_shared<const BrickGrid>(*volume);
  const IsoLanes lanes(IsoSurface(volume, bricks, 800), *bricks);
  RandomRays random(dims, 16);
  RayLanes rays;
  HitLanes together, alone;
  for (int packet = 0; packet < 100; ++packet) {
    for (int n = 0; n < RayLanes::kCount; ++n) set_ray(rays, n, random());
    rays.is_beam = packet % 2 == 1;
    lanes.first_hits(rays, ~0u, together);
    for (int n = 0; n < RayLanes::kCount; ++n) {
      lanes.first_hits(rays, 1u << n, alone);
      ASSERT_EQ(alone.hit, together.hit & 1u << n);
      if (alone.hit != 0) {
        EXPECT_EQ(alone.t[n], together.t[n]);
      }
    }
  }
}

// Rays that begin and end anywhere, beside the surface more often than not.
RayLanes pieces_of_rays(RandomRays& random) {
  RayLanes rays;
  for (int n = 0; n < RayLanes::kCount; ++n) {
    set_ray(rays, n, random());
    rays.begin[n] = static_cast<float>(40 * random.uniform());
    rays.end[n] = rays.begin[n] + static_cast<float>(10 * random.uniform());
  }
  return rays;
}

TEST(IsoLanes, occluded_is_whether_the_oracle_finds_a_root_between_begin_and_end) {
  const std::array<int, 3> dims{19, 23, 17};
  const auto volume =
      std::make_shared<const Volume>(random_volume<std::int16_t>(dims, 9, -1000, 1000));
  const auto bricks = std::make_shared<const BrickGrid>(*volume);
  const IsoSurface oracle(volume, bricks, 700);
  const IsoLanes lanes(oracle, *bricks);
  RandomRays random(dims, 17);
  int occluded_rays = 0, close = 0;
  for (int packet = 0; packet < 3000; ++packet) {
    RayLanes rays = pieces_of_rays(random);
    rays.is_beam = packet % 2 == 1;
    const std::uint32_t occluded = lanes.occluded(rays, ~0u);
    HitLanes hits;
    lanes.first_hits(rays, ~0u, hits);
    ASSERT_EQ(occluded, hits.hit);
    occluded_rays += std::popcount(occluded);
    for (int n = 0; n < RayLanes::kCount; ++n) {
      Ray ray;
      for (int axis = 0; axis < 3; ++axis) {
        ray.origin[axis] = rays.origin[axis][n];
        ray.direction[axis] = rays.direction[axis][n];
      }
      const double begin = rays.begin[n], end = rays.end[n];
      ray.origin = ray.at(begin);
      const auto expected = oracle.first_hit_in_index_space(ray, kInfinity);
      // A root that lies on the end, to the rounding of floats, may count either way.
      if (expected && std::fabs(begin + expected->t - end) < 1e-5) {
        ++close;
        continue;
      }
      ASSERT_EQ((occluded >> n & 1) != 0, expected && begin + expected->t < end);
    }
  }
  EXPECT_GT(occluded_rays, 4000);
  EXPECT_LT(close, 10);
}

TEST(IsoLanes, rays_of_many_packets_in_one_stream_have_the_bits_that_each_packet_has_alone) {
  const std::array<int, 3> dims{19, 23, 17};
  const auto same = [&]<typename T>(T low, T high, double iso) {
    const auto volume = std::make_shared<const Volume>(random_volume<T>(dims, 10, low, high));
    const auto bricks = std::make_shared<const BrickGrid>(*volume);
    const IsoLanes lanes(IsoSurface(volume, bricks, iso), *bricks);
    RandomRays random(dims, 18);
    int met = 0;
    // As few and as many as go together, and more; packets without a lane among them.
    for (const std::size_t count : {std::size_t{1}, std::size_t{2}, IsoLanes::kPacketsAtOnce,
                                    2 * IsoLanes::kPacketsAtOnce + 3, std::size_t{100}}) {
      std::vector<RayLanes> rays(count);
      std::vector<std::uint32_t> asked(count);
      for (std::size_t p = 0; p < count; ++p) {
        rays[p] = pieces_of_rays(random);
        asked[p] = p % 5 == 3 ? 0 : p % 3 == 0 ? ~0u : random.integer();
      }
      std::vector<HitLanes> together(count);
      std::vector<std::uint32_t> occluded = asked;
      lanes.first_hits(rays, asked, together);
      lanes.occluded(rays, occluded);
      for (std::size_t p = 0; p < count; ++p) {
        HitLanes alone;
        lanes.first_hits(rays[p], asked[p], alone);
        ASSERT_EQ(together[p].hit, alone.hit) << p << " of " << count;
        ASSERT_EQ(together[p].hit & ~asked[p], 0u);
        EXPECT_EQ(occluded[p], alone.hit);
        EXPECT_EQ(together[p].turned & alone.hit, alone.turned & alone.hit);
        for (int n = 0; n < RayLanes::kCount; ++n) {
          if (!(alone.hit >> n & 1)) continue;
          ++met;
          EXPECT_EQ(together[p].t[n], alone.t[n]);
          for (int axis = 0; axis < 3; ++axis) {
            EXPECT_EQ(together[p].normal[axis][n], alone.normal[axis][n]);
          }
        }
      }
    }
    EXPECT_GT(met, 100);
  };
  same(std::uint8_t{0}, std::uint8_t{255}, 200.5);
  same(std::int16_t{-1000}, std::int16_t{1000}, 700);
  same(std::uint16_t{0}, std::uint16_t{60000}, 50000);
  same(-1.0f, 1.0f, 0.7);
}

TEST(IsoLanes, a_root_counts_before_the_end_and_after_the_beginning) {
  // In z the field is z, so a ray up from z = 0 meets the iso value 3.5 at t = 3.5 exactly.
  Volume ramp;
  ramp.dims = {2, 2, 9};
  std::vector<float> voxels;
  for (int n = 0; n < 2 * 2 * 9; ++n) voxels.push_back(static_cast<float>(n / 4));
  ramp.voxels = std::move(voxels);
  const auto volume = std::make_shared<const Volume>(ramp);
  const auto bricks = std::make_shared<const BrickGrid>(*volume);
  const IsoLanes lanes(IsoSurface(volume, bricks, 3.5), *bricks);
  const float after = std::nextafter(3.5f, 4.0f), before = std::nextafter(3.5f, 3.0f);
  const float begins[]{0, 0, 0, 3.25f, 3.5f, after}, ends[]{before, 3.5f, after, 3.75f, 9, 9};
  RayLanes rays;
  for (int n = 0; n < 6; ++n) {
    set_ray(rays, n, {{0.5, 0.5, 0}, {0, 0, 1}});
    rays.begin[n] = begins[n];
    rays.end[n] = ends[n];
  }
  EXPECT_EQ(lanes.occluded(rays, 0b111111), 0b001100u);
  EXPECT_EQ(lanes.occluded(rays, 0b000100), 0b000100u);
  HitLanes hits;
  lanes.first_hits(rays, 0b111111, hits);
  EXPECT_EQ(hits.hit, 0b001100u);
}

TEST(IsoLanes, agree_with_the_oracle_on_the_sphere_and_from_inside_it) {
  const Volume sphere = sphere_phantom();
  expect_agreement(compare(sphere, 0.5, 2000, RandomRays(sphere.dims, 21)));
  RandomRays random(sphere.dims, 22);
  const Disagreements inside = compare(sphere, 0.5, 2000, [&]() -> Ray {
    const Vec3 to{random.uniform() - 0.5, random.uniform() - 0.5, random.uniform() - 0.5};
    return {{32, 32, 32}, normalize(to)};
  });
  expect_agreement(inside);
  EXPECT_EQ(inside.hits, inside.rays);  // nothing escapes from a closed shape
}

// 8 x 4 pixels after 8 x 4 pixels, each from another eye: from afar or from inside, with rays that
// spread or run along an axis, from a tenth of a cell to two cells apart.
class RaysOfPixels {
 public:
  RaysOfPixels(const std::array<int, 3>& dims, unsigned seed) : dims_(dims), random_(dims, seed) {}

  Ray operator()() {
    if (pixel_ == 0) look_from_elsewhere();
    const int x = (pixel_ & 3) + (pixel_ >> 4 << 2), y = pixel_ >> 2 & 3;
    pixel_ = (pixel_ + 1) % RayLanes::kCount;
    return {first_.origin + x * origin_x_ + y * origin_y_,
            first_.direction + x * direction_x_ + y * direction_y_};
  }

 private:
  void look_from_elsewhere() {
    first_ = random_();
    origin_x_ = origin_y_ = direction_x_ = direction_y_ = {};
    const double apart = std::pow(10, -1 + 1.3 * random_.uniform());
    const Vec3 x{random_.uniform() - 0.5, random_.uniform() - 0.5, random_.uniform() - 0.5};
    const Vec3 y{random_.uniform() - 0.5, random_.uniform() - 0.5, random_.uniform() - 0.5};
    if (random_.integer() % 3 != 0) {
      direction_x_ = apart / 30 * x;
      direction_y_ = apart / 30 * y;
      if (random_.integer() % 2 == 0) first_.origin = first_.origin + 30.0 * first_.direction;
      return;
    }
    const int axis = static_cast<int>(random_.integer() % 3);
    first_.direction = {};
    first_.direction[axis] = random_.integer() % 2 == 0 ? 1 : -1;
    for (int a = 0; a < 3; ++a)
      first_.origin[a] = random_.integer() % dims_[static_cast<std::size_t>(a)];
    first_.origin[axis] = -100 * first_.direction[axis];
    origin_x_[(axis + 1) % 3] = random_.integer() % 2 == 0 ? 0.5 : apart;
    origin_y_[(axis + 2) % 3] = random_.integer() % 2 == 0 ? -0.5 : apart;
  }

  std::array<int, 3> dims_;
  RandomRays random_;
  int pixel_ = 0;
  Ray first_;
  Vec3 origin_x_, origin_y_, direction_x_, direction_y_;
};

TEST(IsoLanes, agree_on_the_rays_of_neighbouring_pixels) {
  const std::array<int, 3> dims{21, 18, 27};
  expect_agreement(
      compare(random_volume<std::uint8_t>(dims, 51, 0, 256), 230.5, 1000, RaysOfPixels(dims, 52)));
  expect_agreement(
      compare(random_volume<float>(dims, 53, -1, 1), 0.8, 1000, RaysOfPixels(dims, 54)));
  const Volume head = head_phantom(40);
  expect_agreement(compare(head, 300, 1000, RaysOfPixels(head.dims, 55)));
}

TEST(IsoLanes, agree_on_thin_sheets_along_a_diagonal) {
  // Voxels with i == j are above, all others below: both crossings lie in one cell.
  Volume sheet;
  sheet.dims = {16, 16, 8};
  std::vector<std::int16_t> voxels;
  for (int n = 0; n < 16 * 16 * 8; ++n) voxels.push_back(n % 16 == n / 16 % 16 ? 1000 : -900);
  sheet.voxels = std::move(voxels);
  expect_agreement(compare(sheet, 0, 2000, RandomRays(sheet.dims, 31)));
}

TEST(IsoLanes, agree_on_rays_along_faces_edges_and_through_corners) {
  const std::array<int, 3> dims{9, 8, 10};
  RandomRays random(dims, 41);
  const auto ray_on_grid = [&]() -> Ray {
    Vec3 from, to;
    for (int axis = 0; axis < 3; ++axis) {
      from[axis] = random.integer() % dims[static_cast<std::size_t>(axis)];
      to[axis] = random.integer() % dims[static_cast<std::size_t>(axis)];
    }
    const int axis = static_cast<int>(random.integer() % 3);
    if (random.integer() % 2) {
      to = from;
      to[axis] += random.integer() % 2 ? 1 : -1;
    }
    if (from == to) to[axis] += 1;
    const Vec3 direction = to - from;
    return {from - 20.0 * direction, direction};
  };
  expect_agreement(
      compare(random_volume<std::int16_t>(dims, 5, -1000, 1000), 500.5, 4000, ray_on_grid));
  expect_agreement(compare(random_volume<float>(dims, 6, -1, 1), 0.4, 4000, ray_on_grid));
}

}  // namespace
}  // namespace isolux
