// IsoSurface against an oracle that looks at every cell, and against closed forms.

#include "isolux/intersect/iso_surface.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <memory>
#include <numbers>
#include <sstream>
#include <string>
#include <type_traits>
#include <vector>

#include "closed_form/brute_force_walker.h"
#include "isolux/volume/phantom.h"

namespace isolux::test {
namespace {

/// SplitMix64 (Steele, Lea and Flood 2014, "Fast splittable pseudorandom number generators"): the
/// same rays on every machine.
class Dice {
 public:
  explicit Dice(std::uint64_t seed) : state_(seed) {}

  std::uint64_t bits() {
    std::uint64_t z = state_ += 0x9e3779b97f4a7c15u;
    z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9u;
    z = (z ^ (z >> 27)) * 0x94d049bb133111ebu;
    return z ^ (z >> 31);
  }
  /// In [low, high], a multiple of 2^-53 of the way.
  double between(double low, double high) {
    return low + (high - low) * (static_cast<double>(bits() >> 11) * 0x1p-53);
  }
  /// One of low, low + 1, ..., high.
  int whole(int low, int high) {
    return low + static_cast<int>(bits() % static_cast<std::uint64_t>(high - low + 1));
  }
  bool chance(double p) { return between(0, 1) < p; }
  Vec3 in_box(Vec3 low, Vec3 high) {
    return {between(low.x, high.x), between(low.y, high.y), between(low.z, high.z)};
  }
  Vec3 unit_vector() {
    const double z = between(-1, 1), phi = between(0, 2 * std::numbers::pi);
    const double r = std::sqrt(1 - z * z);
    return {r * std::cos(phi), r * std::sin(phi), z};
  }

 private:
  std::uint64_t state_;
};

// ---- Scenes ----------------------------------------------------------------------------------

using Dims = std::array<int, 3>;

Vec3 last_voxel(const Dims& dims) {
  return {static_cast<double>(dims[0] - 1), static_cast<double>(dims[1] - 1),
          static_cast<double>(dims[2] - 1)};
}

/// A volume of T with the value `value_at(i, j, k)` at each voxel.
template <typename T, typename ValueAt>
Volume filled(const Dims& dims, const Affine& world_from_index, ValueAt&& value_at) {
  std::vector<T> voxels;
  for (int k = 0; k < dims[2]; ++k) {
    for (int j = 0; j < dims[1]; ++j) {
      for (int i = 0; i < dims[0]; ++i) voxels.push_back(static_cast<T>(value_at(i, j, k)));
    }
  }
  return {dims, std::move(voxels), world_from_index, "", ""};
}

IsoSurface surface_of(const Volume& volume, double iso) {
  return IsoSurface(std::make_shared<const Volume>(volume),
                    std::make_shared<const BrickGrid>(volume), iso);
}

Mat3 random_rotation(Dice& dice) {
  const Vec3 a = dice.unit_vector();
  Vec3 b = dice.unit_vector();
  while (length(cross(a, b)) < 0.1) b = dice.unit_vector();
  const Vec3 c = normalize(cross(a, b));
  return {{a, cross(c, a), c}};
}

/// Anisotropic and rotated; half of them sheared, half of them mirrored, some with axes exchanged.
Affine random_affine(Dice& dice) {
  Mat3 m = random_rotation(dice) * diagonal(dice.in_box({0.3, 0.3, 0.3}, {3, 3, 3}));
  if (dice.chance(0.5)) {
    Mat3 shear;
    shear.column[1].x = dice.between(-0.7, 0.7);
    shear.column[2].x = dice.between(-0.7, 0.7);
    shear.column[2].y = dice.between(-0.7, 0.7);
    m = m * shear;
  }
  if (dice.chance(0.5)) m.column[0] = -m.column[0];
  if (dice.chance(0.3)) std::swap(m.column[1], m.column[2]);
  return {m, dice.in_box({-50, -50, -50}, {50, 50, 50})};
}

/// Spacings and an origin that are whole multiples of 1/8, the spacings powers of two: index space
/// is reached without any rounding, so a ray can be exactly in a face.
Affine exact_affine(Dice& dice) {
  const auto power = [&] { return std::ldexp(dice.chance(0.5) ? 1 : -1, dice.whole(-2, 2)); };
  const auto eighths = [&] { return dice.whole(-400, 400) / 8.0; };
  return {diagonal({power(), power(), power()}), {eighths(), eighths(), eighths()}};
}

Dims random_dims(Dice& dice) { return {dice.whole(5, 12), dice.whole(5, 12), dice.whole(5, 12)}; }

/// Noise over the type's range, noise of three values (so with constant regions), or a smooth
/// field, which most often has long clean surfaces.
template <typename T>
Volume random_volume(Dice& dice, const Dims& dims, const Affine& world_from_index) {
  const double low = std::is_same_v<T, std::int16_t> ? -30000 : 0;
  const double high = std::is_same_v<T, float> ? 1 : std::is_same_v<T, std::uint8_t> ? 255 : 30000;
  const int kind = dice.whole(0, 2);
  const Vec3 wave = dice.in_box({-1, -1, -1}, {1, 1, 1});
  return filled<T>(dims, world_from_index, [&](int i, int j, int k) {
    if (kind == 0) return dice.between(low, high);
    if (kind == 1) return low + (high - low) * 0.5 * std::max(0, dice.whole(-2, 2));
    const double phase = wave.x * i + 1.3 * wave.y * j + 0.8 * wave.z * k;
    return low + (high - low) * (0.5 + 0.5 * std::sin(phase) * std::cos(0.6 * (i - j) * wave.z));
  });
}

/// A value between those of two random voxels, or exactly that of one.
double random_iso(Dice& dice, const Volume& volume) {
  return visit_voxels(volume, [&](const auto& view) {
    const auto any = [&] {
      return view.value(dice.whole(0, view.dims[0] - 1), dice.whole(0, view.dims[1] - 1),
                        dice.whole(0, view.dims[2] - 1));
    };
    const double a = any(), b = any();
    const double iso = dice.chance(0.4) ? a : a + (b - a) * dice.between(0, 1);
    return std::isfinite(iso) ? iso : 0.5;
  });
}

/// Carried from index space; a direction is made unit in world space.
Ray world_ray(const Affine& world_from_index, Vec3 index_origin, Vec3 index_direction) {
  return {world_from_index.point(index_origin),
          normalize(world_from_index.vector(index_direction))};
}

/// From outside through a random point of the box, or from a random point within it.
Ray random_ray(Dice& dice, const Volume& volume) {
  const Vec3 box = last_voxel(volume.dims);
  const Vec3 inside = dice.in_box({0, 0, 0}, box);
  const Vec3 direction = dice.unit_vector();
  const double back = dice.chance(0.5) ? 0 : dice.between(1, 3) * length(box);
  return world_ray(volume.world_from_index, inside - back * direction, direction);
}

/// In a plane of voxels, along a row of voxels, or through voxel centres askew.
Ray lattice_ray(Dice& dice, const Volume& volume) {
  const Vec3 box = last_voxel(volume.dims);
  Vec3 through, direction;
  const int kind = dice.whole(0, 2);
  const int axis = dice.whole(0, 2);
  for (int a = 0; a < 3; ++a) {
    const bool on_lattice = kind == 2 || (kind == 0) == (a == axis);
    // Multiples of 1/1024, so that an exact affine keeps every digit.
    through[a] = on_lattice ? dice.whole(0, volume.dims[a] - 1)
                            : std::floor(dice.between(0, box[a]) * 1024) / 1024;
    direction[a] = kind == 2    ? dice.whole(-2, 2)
                   : on_lattice ? 0
                                : std::floor(dice.between(-1, 1) * 1024) / 1024;
  }
  if (direction == Vec3{}) direction.x = 1;
  // Steps of whole cells backwards stay on the lattice.
  const double back = dice.chance(0.3) ? 0 : dice.whole(1, 30);
  return world_ray(volume.world_from_index, through - back * direction, direction);
}

// ---- Judging one ray -------------------------------------------------------------------------

struct Tally {
  int rays = 0;
  int must_hit = 0;   ///< rays that must meet the surface
  int must_miss = 0;  ///< rays that cannot
  int times_compared = 0;
  int normals_compared = 0;
  int faults = 0;
  std::string first_fault;
};

std::string text(Vec3 v) {
  std::ostringstream out;
  out.precision(17);
  out << "{" << v.x << ", " << v.y << ", " << v.z << "}";
  return out.str();
}

/// The length by which errors along a ray are measured: the volume's own, or that of the numbers
/// that place it and the ray.
double size_scale_mm(const Volume& volume, const Ray& ray) {
  const auto corners = box_corners(volume);
  return std::max({length(corners[7] - corners[0]), length(volume.world_from_index.offset),
                   length(ray.origin)});
}

/// Shared by all scenes: what a right answer is, given what the oracle knows.
std::string fault_of(const IsoSurface& surface, const BruteForceWalker& walker, const Ray& ray,
                     Tally& tally) {
  const FirstMeeting meeting = walker.first_meeting(ray);
  const std::optional<IsoHit> hit = surface.first_hit(ray);
  const double size = size_scale_mm(surface.volume(), ray);
  const double t_tolerance = 1e-9 * size;
  std::ostringstream fault;
  fault.precision(17);
  fault << "ray " << text(ray.origin) << " " << text(ray.direction) << ": may hit from "
        << meeting.may_hit_from << ", first root " << meeting.first_root << ", must hit by "
        << meeting.must_hit_by << "; ";

  const bool must_hit = meeting.must_hit_by < FirstMeeting::kNever;
  ++tally.rays;
  tally.must_hit += must_hit;
  tally.must_miss += !(meeting.may_hit_from < FirstMeeting::kNever);
  if (!hit) {
    fault << "missed";
    return must_hit ? fault.str() : "";
  }

  fault << "t " << hit->t << " cell " << hit->cell[0] << " " << hit->cell[1] << " " << hit->cell[2]
        << " local " << text(hit->local) << ": ";
  const Vec3 index{hit->cell[0] + hit->local.x, hit->cell[1] + hit->local.y,
                   hit->cell[2] + hit->local.z};
  for (int axis = 0; axis < 3; ++axis) {
    if (hit->cell[axis] < 0 || hit->cell[axis] > surface.volume().dims[axis] - 2 ||
        !(hit->local[axis] >= 0 && hit->local[axis] <= 1)) {
      fault << "outside the volume";
      return fault.str();
    }
  }
  if (!(hit->t > 0)) {
    fault << "not before the eye";
    return fault.str();
  }
  const double off_ray_mm = length(surface.volume().world_from_index.point(index) - ray.at(hit->t));
  if (!(off_ray_mm <= t_tolerance)) {
    fault << "off the ray by " << off_ray_mm << " mm";
    return fault.str();
  }
  const double position_doubt =
      std::max(meeting.position_doubt, walker.position_doubt(ray, hit->t));
  const double off_iso = std::fabs(walker.value(hit->cell, hit->local) - surface.iso());
  if (!(off_iso <= walker.value_doubt(position_doubt))) {
    fault << "off the iso value by " << off_iso << ", allowed "
          << walker.value_doubt(position_doubt);
    return fault.str();
  }
  if (hit->t > meeting.must_hit_by + t_tolerance) {
    fault << "an earlier meeting was passed over";
    return fault.str();
  }
  // Where the ray crosses cleanly there is one right number.
  if (meeting.must_hit_by - meeting.may_hit_from <= t_tolerance / 4) {
    ++tally.times_compared;
    if (!(std::fabs(hit->t - meeting.first_root) <= t_tolerance)) {
      fault << "t differs by " << hit->t - meeting.first_root;
      return fault.str();
    }
  }

  const std::optional<Vec3> normal = surface.normal(*hit);
  const WalkedNormal expected = walker.normal(hit->cell, hit->local);
  if (normal && !(std::fabs(length(*normal) - 1) <= 1e-12)) {
    fault << "normal is not unit: " << text(*normal);
    return fault.str();
  }
  // 1e-2: at most two of sixteen digits are lost in summing the gradient.
  if (expected.strength > 1e-2) {
    ++tally.normals_compared;
    if (!normal || !(length(*normal - *expected.unit) <= 1e-9)) {
      fault << "normal " << (normal ? text(*normal) : "nothing") << ", expected "
            << text(*expected.unit);
      return fault.str();
    }
  }
  return "";
}

void judge(const IsoSurface& surface, const BruteForceWalker& walker, const Ray& ray,
           Tally& tally) {
  const std::string fault = fault_of(surface, walker, ray, tally);
  if (fault.empty()) return;
  if (tally.faults++ == 0) {
    std::ostringstream out;
    out.precision(17);
    const Volume& v = surface.volume();
    const Affine& a = v.world_from_index;
    out << fault << "\n  dims " << v.dims[0] << " " << v.dims[1] << " " << v.dims[2] << " "
        << voxel_type_name(v) << " iso " << surface.iso() << " columns " << text(a.linear.column[0])
        << text(a.linear.column[1]) << text(a.linear.column[2]) << " offset " << text(a.offset);
    tally.first_fault = out.str();
  }
}

void expect_no_fault(const Tally& tally) {
  EXPECT_EQ(tally.faults, 0) << "of " << tally.rays << " rays; the first:\n  " << tally.first_fault;
}

// ---- Against the oracle ----------------------------------------------------------------------

template <typename T>
class EveryVoxelType : public ::testing::Test {};
using VoxelTypes = ::testing::Types<std::uint8_t, std::int16_t, std::uint16_t, float>;
TYPED_TEST_SUITE(EveryVoxelType, VoxelTypes);

/// Other scenes for every type.
template <typename T>
constexpr std::uint64_t kSeedOf = 10 * sizeof(T) + std::is_signed_v<T>;

TYPED_TEST(EveryVoxelType, is_hit_where_a_search_of_every_cell_finds_the_first_root) {
  Dice dice(100 + kSeedOf<TypeParam>);
  Tally tally;
  for (int scene = 0; scene < 60; ++scene) {
    const auto volume = random_volume<TypeParam>(dice, random_dims(dice), random_affine(dice));
    const double iso = random_iso(dice, volume);
    const IsoSurface surface = surface_of(volume, iso);
    const BruteForceWalker walker(volume, iso);
    for (int n = 0; n < 100; ++n) judge(surface, walker, random_ray(dice, volume), tally);
  }
  expect_no_fault(tally);
  // The comparison would prove little if most rays were doubtful.
  EXPECT_GT(tally.must_hit, tally.rays / 4);
  EXPECT_GT(tally.must_miss, tally.rays / 50);
  EXPECT_GT(tally.must_hit + tally.must_miss, tally.rays * 3 / 4);
  EXPECT_GT(tally.times_compared, tally.must_hit / 2);
  EXPECT_GT(tally.normals_compared, tally.must_hit / 2);
}

TYPED_TEST(EveryVoxelType, is_hit_by_rays_along_faces_and_edges_and_through_voxel_centres) {
  Dice dice(200 + kSeedOf<TypeParam>);
  Tally tally;
  for (int scene = 0; scene < 60; ++scene) {
    // On an exact grid the rays truly lie in the faces, the outer ones too; on a turned grid they
    // wander about them by roundings.
    const bool is_exact = scene % 2 == 0;
    const auto volume = random_volume<TypeParam>(
        dice, random_dims(dice), is_exact ? exact_affine(dice) : random_affine(dice));
    const double iso = random_iso(dice, volume);
    const IsoSurface surface = surface_of(volume, iso);
    const BruteForceWalker walker(volume, iso,
                                  is_exact ? OuterFace::kBelongs : OuterFace::kEitherWay);
    for (int n = 0; n < 100; ++n) judge(surface, walker, lattice_ray(dice, volume), tally);
  }
  expect_no_fault(tally);
  EXPECT_GT(tally.must_hit, tally.rays / 3);
}

TEST(iso_hit, long_thin_volumes_of_many_bricks_are_searched_to_their_ends) {
  Dice dice(3);
  Tally tally;
  for (const Dims& dims : {Dims{40, 3, 17}, Dims{2, 33, 9}, Dims{17, 2, 2}, Dims{9, 18, 10}}) {
    for (int scene = 0; scene < 6; ++scene) {
      // Mostly empty, so that whole bricks are skipped, and often a brick's only surface is about a
      // voxel that it shares with the next.
      const double density = dice.chance(0.5) ? 0.002 : 0.04;
      const Volume volume = filled<std::int16_t>(dims, random_affine(dice), [&](int, int, int) {
        return dice.chance(density) ? 1000 : 0;
      });
      const double iso = dice.between(1, 999);
      const IsoSurface surface = surface_of(volume, iso);
      const BruteForceWalker walker(volume, iso);
      for (int n = 0; n < 100; ++n) judge(surface, walker, random_ray(dice, volume), tally);
      for (int n = 0; n < 50; ++n) judge(surface, walker, lattice_ray(dice, volume), tally);
    }
  }
  expect_no_fault(tally);
  EXPECT_GT(tally.must_hit, tally.rays / 20);
  EXPECT_GT(tally.must_miss, tally.rays / 20);
}

TEST(iso_hit, a_surface_through_voxel_centres_has_no_crack_there) {
  // f rises by 1000 a voxel along every axis, give or take 200, so every ray that leans forward
  // along all three rises too, and crosses the value of the voxel that it is aimed at just there:
  // at a corner of eight cells, where rounding may put it into any of them.
  Dice dice(17);
  Tally tally;
  for (int scene = 0; scene < 60; ++scene) {
    const auto volume = std::make_shared<const Volume>(filled<std::int16_t>(
        {10, 11, 10}, scene % 3 == 0 ? exact_affine(dice) : random_affine(dice),
        [&](int i, int j, int k) { return 1000 * (i + j + k) + dice.whole(-100, 100); }));
    const auto bricks = std::make_shared<const BrickGrid>(*volume);
    for (int n = 0; n < 500; ++n) {
      const Dims voxel{dice.whole(1, 8), dice.whole(1, 9), dice.whole(1, 8)};
      const Vec3 target{1.0 * voxel[0], 1.0 * voxel[1], 1.0 * voxel[2]};
      const double iso = visit_voxels(
          *volume, [&](const auto& view) { return view.value(voxel[0], voxel[1], voxel[2]); });
      Vec3 direction = dice.in_box({0, 0, 0}, {1, 1, 1});
      if (n % 3 == 0) direction = {1, 1, n % 2 ? 1.0 : 0.0};
      const double back = dice.between(1, 20);
      const Ray ray = world_ray(volume->world_from_index, target - back * direction, direction);
      const IsoSurface surface(volume, bricks, iso);
      ASSERT_TRUE(surface.first_hit(ray)) << text(ray.origin) << text(ray.direction);
      if (n < 30) judge(surface, BruteForceWalker(*volume, iso), ray, tally);
    }
  }
  expect_no_fault(tally);
  EXPECT_EQ(tally.must_hit, tally.rays);
}

TEST(iso_hit, an_origin_a_hundred_metres_away_costs_only_the_digits_of_its_own_size) {
  Dice dice(4);
  Tally tally;
  for (int scene = 0; scene < 40; ++scene) {
    Affine far_away = random_affine(dice);
    far_away.offset = 1e5 * dice.in_box({-1, -1, -1}, {1, 1, 1});
    const Volume volume = random_volume<std::int16_t>(dice, random_dims(dice), far_away);
    const double iso = random_iso(dice, volume);
    const IsoSurface surface = surface_of(volume, iso);
    const BruteForceWalker walker(volume, iso);
    for (int n = 0; n < 100; ++n) judge(surface, walker, random_ray(dice, volume), tally);
  }
  expect_no_fault(tally);
  EXPECT_GT(tally.times_compared, tally.rays / 4);
}

TEST(iso_hit, an_eye_a_hundred_metres_away_sees_the_same_surface) {
  Dice dice(5);
  Tally tally;
  for (int scene = 0; scene < 40; ++scene) {
    const Volume volume =
        random_volume<std::uint16_t>(dice, random_dims(dice), random_affine(dice));
    const double iso = random_iso(dice, volume);
    const IsoSurface surface = surface_of(volume, iso);
    const BruteForceWalker walker(volume, iso);
    for (int n = 0; n < 100; ++n) {
      const Ray near = random_ray(dice, volume);
      judge(surface, walker, {near.at(-1e5), near.direction}, tally);
    }
  }
  expect_no_fault(tally);
  EXPECT_GT(tally.times_compared, tally.rays / 4);
}

TEST(iso_hit, a_cell_with_a_nan_corner_holds_nothing_and_hides_nothing) {
  Dice dice(6);
  Tally tally;
  const float nan = std::numeric_limits<float>::quiet_NaN();
  for (int scene = 0; scene < 80; ++scene) {
    Volume volume = random_volume<float>(dice, random_dims(dice), random_affine(dice));
    const double nans = dice.chance(0.5) ? 0.01 : 0.1;
    const auto& whole = std::get<Voxels<float>>(volume.voxels);
    std::vector<float> holed(whole.begin(), whole.end());
    for (float& v : holed) {
      if (dice.chance(nans)) v = nan;
    }
    volume.voxels = std::move(holed);
    const double iso = random_iso(dice, volume);
    const IsoSurface surface = surface_of(volume, iso);
    const BruteForceWalker walker(volume, iso);
    for (int n = 0; n < 100; ++n) judge(surface, walker, random_ray(dice, volume), tally);
    for (int n = 0; n < 30; ++n) judge(surface, walker, lattice_ray(dice, volume), tally);
  }
  expect_no_fault(tally);
  EXPECT_GT(tally.must_hit, tally.rays / 4);
}

TEST(iso_hit, a_volume_of_nan_alone_is_never_hit) {
  Dice dice(7);
  const Volume volume = filled<float>({5, 6, 7}, random_affine(dice), [](int, int, int) {
    return std::numeric_limits<float>::quiet_NaN();
  });
  const IsoSurface surface = surface_of(volume, 0.5);
  for (int n = 0; n < 500; ++n) EXPECT_FALSE(surface.first_hit(random_ray(dice, volume)));
}

TEST(iso_hit, no_hit_lies_beyond_t_max_and_none_before_it_is_lost) {
  Dice dice(8);
  int compared = 0;
  for (int scene = 0; scene < 20; ++scene) {
    const Volume volume = random_volume<std::int16_t>(dice, random_dims(dice), random_affine(dice));
    // Between whole values: a ray that starts within cells equal to iso has no first root.
    const IsoSurface surface = surface_of(volume, std::floor(random_iso(dice, volume)) + 0.5);
    for (int n = 0; n < 100; ++n) {
      const Ray ray = random_ray(dice, volume);
      const auto hit = surface.first_hit(ray);
      if (!hit) continue;
      ++compared;
      const auto just_before = surface.first_hit(ray, hit->t * (1 - 1e-9));
      EXPECT_FALSE(just_before) << just_before->t << " before the first hit at " << hit->t;
      const auto just_after = surface.first_hit(ray, hit->t * (1 + 1e-9));
      ASSERT_TRUE(just_after);
      EXPECT_NEAR(just_after->t, hit->t, 1e-9 * hit->t);
      EXPECT_LE(just_after->t, hit->t * (1 + 1e-9));
    }
  }
  EXPECT_GT(compared, 500);
}

// ---- Cells wholly equal to the iso value -----------------------------------------------------

/// Voxels 3..6 along each axis are equal to 100, so cells 3..5 are; all others are greater (or,
/// with `sign` -1, less): f touches 100 nowhere but in the block.
Volume block_at_iso(Dice& dice, int sign, const Affine& world_from_index) {
  return filled<std::int16_t>({10, 10, 10}, world_from_index, [&](int i, int j, int k) {
    const auto within = [](int n) { return n >= 3 && n <= 6; };
    return within(i) && within(j) && within(k) ? 100 : 100 + sign * dice.whole(1, 50);
  });
}

TEST(iso_hit, a_block_wholly_equal_to_iso_is_met_where_the_ray_enters_it) {
  Dice dice(9);
  for (int scene = 0; scene < 40; ++scene) {
    const bool is_exact = scene % 2 == 0;
    const Volume volume = block_at_iso(dice, scene % 4 < 2 ? 1 : -1,
                                       is_exact ? exact_affine(dice) : random_affine(dice));
    const IsoSurface surface = surface_of(volume, 100);
    for (int n = 0; n < 50; ++n) {
      // Onto a random point of the face i = 3 of the block, from before it: nothing else of the
      // block can come first, and t is the distance to that point.
      const bool is_straight = n % 5 == 0;
      Vec3 on_face{3, dice.between(3.01, 5.99), dice.between(3.01, 5.99)};
      // Without rounding, also along the block's own faces, edges and rows of voxels.
      if (is_exact && is_straight) on_face.y = dice.whole(3, 6);
      if (is_exact && n % 10 == 0) on_face.z = dice.whole(3, 6);
      const Vec3 step{dice.between(0.2, 2.9), is_straight ? 0 : dice.between(-2, 2),
                      is_straight ? 0 : dice.between(-2, 2)};
      const Vec3 from = volume.world_from_index.point(on_face - step);
      const Vec3 to = volume.world_from_index.point(on_face);
      const auto hit = surface.first_hit({from, normalize(to - from)});
      ASSERT_TRUE(hit) << "onto " << text(on_face) << " from " << text(on_face - step);
      // Before the face f differs from 100 by 1 or more a voxel, linearly, so rounding f by 1e-13
      // moves the hit by 1e-13 voxel.
      EXPECT_NEAR(hit->t, length(to - from), 1e-9 * size_scale_mm(volume, {from, {}}));
    }
  }
}

TEST(iso_hit, a_ray_that_starts_within_a_block_equal_to_iso_is_met_before_it_leaves_its_cell) {
  // Every t > 0 within the block is a root, so there is no first one and any counts; but the next
  // cell of the block, if there is one, would be met on entry.
  Dice dice(10);
  for (int scene = 0; scene < 20; ++scene) {
    const Volume volume = block_at_iso(dice, scene % 2 ? 1 : -1, random_affine(dice));
    const IsoSurface surface = surface_of(volume, 100);
    for (int n = 0; n < 50; ++n) {
      const Vec3 from = dice.in_box({3.01, 3.01, 3.01}, {5.99, 5.99, 5.99});
      const Vec3 direction = dice.unit_vector();
      double steps_to_wall = FirstMeeting::kNever;
      for (int axis = 0; axis < 3; ++axis) {
        const double wall = std::floor(from[axis]) + (direction[axis] > 0 ? 1 : 0);
        steps_to_wall = std::min(steps_to_wall, (wall - from[axis]) / direction[axis]);
      }
      const Ray ray = world_ray(volume.world_from_index, from, direction);
      const auto hit = surface.first_hit(ray);
      ASSERT_TRUE(hit);
      EXPECT_GT(hit->t, 0);
      EXPECT_LE(hit->t, steps_to_wall * length(volume.world_from_index.vector(direction)) +
                            1e-9 * size_scale_mm(volume, ray));
    }
  }
}

TEST(iso_hit, a_flat_field_at_iso_is_hit_with_no_normal_and_next_to_iso_is_missed) {
  Dice dice(11);
  const Affine placed = random_affine(dice);
  const Volume volume = filled<std::uint8_t>({9, 10, 11}, placed, [](int, int, int) { return 7; });
  const IsoSurface at = surface_of(volume, 7);
  const IsoSurface above = surface_of(volume, std::nextafter(7.0, 8.0));
  const IsoSurface below = surface_of(volume, std::nextafter(7.0, 6.0));
  for (int n = 0; n < 500; ++n) {
    const Vec3 target = dice.in_box({0.1, 0.1, 0.1}, {7.9, 8.9, 9.9});
    const Vec3 direction = dice.unit_vector();
    const Ray ray = world_ray(placed, target - 40 * direction, direction);
    const auto hit = at.first_hit(ray);
    ASSERT_TRUE(hit);
    EXPECT_FALSE(at.normal(*hit));
    EXPECT_FALSE(above.first_hit(ray));
    EXPECT_FALSE(below.first_hit(ray));
  }
}

// ---- Sheets one voxel thick ------------------------------------------------------------------

/// 1 where i == j, else 0.
template <typename T>
Volume diagonal_sheet(const Dims& dims, const Affine& world_from_index) {
  return filled<T>(dims, world_from_index, [](int i, int j, int) { return i == j ? 1 : 0; });
}

/// Across the sheet, more or less steeply, through a point of it at least a cell from its border.
Ray ray_across_sheet(Dice& dice, const Volume& sheet) {
  const double along = dice.between(1.5, sheet.dims[0] - 2.5);
  const Vec3 through{along, along, dice.between(1, sheet.dims[2] - 2)};
  const Vec3 direction{1, -1 + dice.between(-0.5, 0.5), dice.between(-0.1, 0.1)};
  const double back = dice.between(2, 20);
  return world_ray(sheet.world_from_index, through - back * direction, direction);
}

/// What a walker sees that takes a cell for empty where f - iso has the same sign at both ends of
/// its span: the planted fault that the sheet is there to catch.
bool is_seen_by_signs_at_cell_faces(const BruteForceWalker& walker, const Ray& ray) {
  for (const CellSpan& span : walker.spans(ray)) {
    if ((span.cubic.front() < 0) != (span.cubic.back() < 0)) return true;
  }
  return false;
}

TEST(iso_hit, a_diagonal_sheet_one_voxel_thick_has_no_hole) {
  // In a cell that the sheet passes, f = 1 - a - b + 2ab with a, b from one of its corners on the
  // sheet; on the sheet a = b, so f = 1 - 2a + 2a^2 >= 1/2 there, while f = 0 from |i - j| = 1 on.
  // Every ray through the sheet therefore meets every iso value in (0, 1/2).
  Dice dice(12);
  Tally tally;
  int missed_by_signs = 0;
  for (int scene = 0; scene < 40; ++scene) {
    const Volume sheet = diagonal_sheet<std::uint8_t>(
        {12, 12, 6}, scene % 2 == 0 ? exact_affine(dice) : random_affine(dice));
    const double iso = dice.between(0.05, 0.499);
    const IsoSurface surface = surface_of(sheet, iso);
    const BruteForceWalker walker(sheet, iso);
    for (int n = 0; n < 100; ++n) {
      const Ray ray = ray_across_sheet(dice, sheet);
      ASSERT_TRUE(surface.first_hit(ray)) << text(ray.origin) << text(ray.direction);
      judge(surface, walker, ray, tally);
      missed_by_signs += !is_seen_by_signs_at_cell_faces(walker, ray);
    }
  }
  expect_no_fault(tally);
  EXPECT_EQ(tally.must_hit, tally.rays);
  // Signs at faces alone lose the rays that enter and leave within one cell: entering it at a = 0,
  // f = 1 - b < iso; for iso = 0.4 and rays straight across that is 0.6 < b < 1.4, two in five.
  EXPECT_GT(missed_by_signs, tally.rays / 10);
}

TEST(iso_hit, two_crossings_close_together_in_one_cell_are_both_real) {
  // Straight across through a + b = c the greatest value is p = 1 - c + c^2/2, at the sheet. Just
  // below it the two crossings are 2 h apart with p - 2 h^2 = iso (f = p - 2 s^2 for a = c/2 + s,
  // b = c/2 - s), so the first lies h before the sheet; just above it there is none.
  const Volume sheet = diagonal_sheet<float>({8, 8, 4}, Affine{});
  for (const double c : {0.75, 1.0, 1.25}) {
    for (const double h : {0.1, 1e-2, 1e-3, 1e-4, 1e-5}) {
      const double peak = 1 - c + c * c / 2;
      const Vec3 on_sheet{3 + c / 2, 3 + c / 2, 1.5};
      const Ray ray{on_sheet - Vec3{2, -2, 0}, normalize({1, -1, 0})};
      const auto hit = surface_of(sheet, peak - 2 * h * h).first_hit(ray);
      ASSERT_TRUE(hit) << "c " << c << " h " << h;
      // f is rounded by about 1e-15, so s by 1e-15 / (4 h).
      EXPECT_NEAR(hit->t, std::sqrt(2.0) * (2 - h), 1e-14 + 1e-15 / h) << "c " << c << " h " << h;
      EXPECT_FALSE(surface_of(sheet, peak + 2 * h * h).first_hit(ray)) << "c " << c << " h " << h;
    }
  }
}

TEST(iso_hit, the_crest_of_a_flat_sheet_at_iso_is_lit_from_the_side_that_is_met) {
  // 1 at i = 4, else 0: f = 1 - |i - 4| touches 1 at its crest only, without crossing it, so a ray
  // may count either way; but on an unturned grid at whole numbers nothing is rounded, and it hits.
  // There the central difference is (0 - 0) / 2 = 0 and f's own gradient in the cell decides.
  const Volume sheet =
      filled<std::uint8_t>({9, 6, 6}, Affine{}, [](int i, int, int) { return i == 4 ? 1 : 0; });
  const IsoSurface surface = surface_of(sheet, 1);
  for (const double side : {-1.0, 1.0}) {
    const Ray ray{{4 + 10 * side, 2.25, 3.5}, {-side, 0, 0}};
    const auto hit = surface.first_hit(ray);
    ASSERT_TRUE(hit);
    EXPECT_EQ(hit->t, 10);
    const auto normal = surface.normal(*hit);
    ASSERT_TRUE(normal);
    // Lower values lie on both sides; the cell of the hit says which is meant.
    const double outward = hit->cell[0] < 4 ? -1 : 1;
    EXPECT_EQ(*normal, (Vec3{outward, 0, 0}));
  }
}

TEST(iso_hit, a_crest_at_iso_on_any_grid_has_a_unit_normal_or_counts_as_missed) {
  Dice dice(13);
  Tally tally;
  for (int scene = 0; scene < 20; ++scene) {
    const Volume sheet = filled<std::uint8_t>({9, 6, 6}, random_affine(dice),
                                              [](int i, int, int) { return i == 4 ? 1 : 0; });
    const IsoSurface surface = surface_of(sheet, 1);
    const BruteForceWalker walker(sheet, 1);
    for (int n = 0; n < 100; ++n) {
      const Ray ray = random_ray(dice, sheet);
      judge(surface, walker, ray, tally);
      if (const auto hit = surface.first_hit(ray)) {
        EXPECT_TRUE(surface.normal(*hit)) << text(ray.origin) << text(ray.direction);
      }
    }
  }
  expect_no_fault(tally);
  EXPECT_EQ(tally.must_hit, 0);
}

// ---- Closed forms ----------------------------------------------------------------------------

TEST(iso_hit, a_linear_field_is_a_plane_to_nine_digits_on_any_grid) {
  Dice dice(14);
  int hits = 0, misses = 0;
  for (int scene = 0; scene < 100; ++scene) {
    // Whole coefficients, so that int16 holds the field exactly: f = a . index + d.
    Vec3 a{};
    while (a == Vec3{}) {
      a = {static_cast<double>(dice.whole(-40, 40)), static_cast<double>(dice.whole(-40, 40)),
           static_cast<double>(dice.whole(-40, 40))};
    }
    const int d = dice.whole(-100, 100);
    const Dims dims{11, 19, 8};
    const Affine placed = random_affine(dice);
    const Volume volume = filled<std::int16_t>(
        dims, placed, [&](int i, int j, int k) { return a.x * i + a.y * j + a.z * k + d; });
    // Through the middle of the box, or nearly.
    const double iso = dot(a, 0.5 * last_voxel(dims)) + d + dice.between(-20, 20);
    const IsoSurface surface = surface_of(volume, iso);
    const Vec3 normal = -normalize(transpose(inverse(placed.linear)) * a);
    for (int n = 0; n < 50; ++n) {
      const Vec3 through = dice.in_box({0, 0, 0}, last_voxel(dims));
      const Vec3 direction = dice.unit_vector();
      const Vec3 from = through - dice.between(0, 40) * direction;
      const double slope = dot(a, direction);
      if (std::fabs(slope) < 0.05 * length(a)) continue;
      const double steps = (iso - d - dot(a, from)) / slope;
      const Vec3 met = from + steps * direction;
      double depth = std::min(steps, 1.0);  // how far within the box, in voxels; < 0: outside
      for (int axis = 0; axis < 3; ++axis) {
        depth = std::min({depth, met[axis], last_voxel(dims)[axis] - met[axis]});
      }
      if (std::fabs(depth) < 1e-9) continue;

      const Ray ray = world_ray(placed, from, direction);
      const auto hit = surface.first_hit(ray);
      ASSERT_EQ(hit.has_value(), depth > 0) << text(ray.origin) << text(ray.direction);
      if (!hit) {
        ++misses;
        continue;
      }
      ++hits;
      EXPECT_NEAR(hit->t, steps * length(placed.vector(direction)),
                  1e-9 * size_scale_mm(volume, ray));
      const auto found = surface.normal(*hit);
      ASSERT_TRUE(found);
      EXPECT_LE(length(*found - normal), 1e-9);
    }
  }
  EXPECT_GT(hits, 1000);
  EXPECT_GT(misses, 500);
}

TEST(iso_hit, the_sphere_phantom_is_a_sphere_within_the_error_of_trilinear_interpolation) {
  // f = 1 - r / 32 has second derivatives in [-1 / (32 r), 0] along every axis. Interpolating along
  // one axis after the other, each step at h = 1 mm errs by at most h^2 / 8 of that and always
  // downwards (f is concave): 0 <= f - If <= 3 / (8 * 32 r_in), with r_in the least r in a cell
  // that the surface passes. f falls by 1/32 a mm, so the surface lies up to 3 / (8 r_in) mm within
  // the sphere of 16 mm; a cell reaches sqrt(3) mm further in. float32 adds half an ulp of 1/2,
  // 2^-25.
  const double sphere_mm = 16;
  const double r_in = sphere_mm - 0.03 - std::sqrt(3.0);
  const double sag_mm = 3 / (8 * r_in);
  ASSERT_LT(sag_mm, 0.03);  // as r_in assumed
  const double float_mm = 32 * 0x1p-25;
  // A central difference errs by h^2 / 6 max |r_xxx|, its blend by h^2 / 8 times the second
  // derivatives of r_x along three axes; |r_xxx| = 3 c (1 - c^2) / r^2 with c = x / r is at most
  // 1.155 / r^2, and |r_xyy| = c |3 y^2 / r^2 - 1| / r^2 is less. All three components, at the
  // neighbours of the cell, 1 mm further in; float32 adds 2^-25 * 32 to each.
  const double stencil_mm = r_in - 1;
  const double component = (1.155 / 6 + 3 * 1.155 / 8) / (stencil_mm * stencil_mm) + float_mm;
  const double sine = std::sqrt(3.0) * component;

  const Volume volume = sphere_phantom(65);
  const IsoSurface surface = surface_of(volume, 0.5);
  Dice dice(15);
  int hits = 0, misses = 0;
  for (int n = 0; n < 20000; ++n) {
    const Vec3 direction = dice.unit_vector();
    Vec3 aside = cross(direction, dice.unit_vector());
    if (length(aside) < 1e-3) continue;
    const double impact_mm = dice.between(0, 20);
    aside = impact_mm * normalize(aside);
    const Ray ray{aside - 100 * direction, direction};
    const auto hit = surface.first_hit(ray);
    if (std::fabs(impact_mm - sphere_mm) > sag_mm + float_mm) {
      ASSERT_EQ(hit.has_value(), impact_mm < sphere_mm) << impact_mm;
    }
    hits += hit.has_value();
    misses += !hit;
    if (!hit) continue;
    const Vec3 p = ray.at(hit->t);
    EXPECT_LE(length(p), sphere_mm + float_mm);
    EXPECT_GE(length(p), sphere_mm - sag_mm - float_mm);
    // Where the ray goes straight in, its t is the closed form's within the same sag.
    if (impact_mm < 8) {
      const double exact = 100 - std::sqrt(sphere_mm * sphere_mm - impact_mm * impact_mm);
      const double cos_incidence = std::sqrt(1 - 8.0 * 8.0 / (15.9 * 15.9));
      EXPECT_GE(hit->t, exact - float_mm / cos_incidence);
      EXPECT_LE(hit->t, exact + (sag_mm + float_mm) / cos_incidence);
    }
    const auto normal = surface.normal(*hit);
    ASSERT_TRUE(normal);
    EXPECT_LE(length(cross(*normal, normalize(p))), sine);
    EXPECT_GT(dot(*normal, p), 0);  // f falls outwards
  }
  EXPECT_GT(hits, 10000);
  EXPECT_GT(misses, 3000);
}

TEST(iso_hit, no_ray_escapes_from_within_a_closed_surface) {
  Dice dice(16);
  int shot = 0, escaped = 0;
  std::string first_escape;
  for (int scene = 0; scene < 4; ++scene) {
    // Blobs with rough skins, all outer voxels far below iso: whatever is above iso is shut in.
    const Dims dims{27, 30, 25};
    std::vector<Vec3> blobs;
    for (int n = 0; n < 8; ++n) blobs.push_back(dice.in_box({6, 6, 6}, {20, 23, 18}));
    const Affine placed = scene == 0 ? Affine{} : random_affine(dice);
    const Volume volume = filled<std::int16_t>(dims, placed, [&](int i, int j, int k) {
      if (i == 0 || j == 0 || k == 0 || i == dims[0] - 1 || j == dims[1] - 1 || k == dims[2] - 1) {
        return -1000.0;
      }
      double sum = -400 + dice.between(-150, 150);
      for (const Vec3& blob : blobs) {
        const Vec3 away = Vec3{1.0 * i, 1.0 * j, 1.0 * k} - blob;
        sum += 1200 * std::exp(-dot(away, away) / 12);
      }
      return sum;
    });
    // A whole value, so that some voxels are exactly at it; those are not "within".
    const double iso = 0;
    const IsoSurface surface = surface_of(volume, iso);
    const BruteForceWalker values(volume, iso);
    for (int n = 0; n < 40000; ++n) {
      const bool is_on_lattice = n % 4 == 0;
      const Dims cell{dice.whole(1, 24), dice.whole(1, 27), dice.whole(1, 22)};
      const Vec3 local = is_on_lattice ? Vec3{} : dice.in_box({0, 0, 0}, {1, 1, 1});
      if (values.value(cell, local) < iso + 1e-6) continue;
      Vec3 direction = dice.unit_vector();
      if (is_on_lattice && n % 8 == 0) {
        direction = {static_cast<double>(dice.whole(-1, 1)), static_cast<double>(dice.whole(-1, 1)),
                     static_cast<double>(dice.whole(-1, 1))};
        if (direction == Vec3{}) direction = {0, 0, 1};
      }
      const Ray ray =
          world_ray(placed, Vec3{1.0 * cell[0], 1.0 * cell[1], 1.0 * cell[2]} + local, direction);
      ++shot;
      if (surface.first_hit(ray)) continue;
      if (escaped++ == 0) first_escape = text(ray.origin) + text(ray.direction);
    }
  }
  EXPECT_GT(shot, 10000);
  EXPECT_EQ(escaped, 0) << "of " << shot << "; the first: " << first_escape;
}

}  // namespace
}  // namespace isolux::test
