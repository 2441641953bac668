#include "isolux/intersect/iso_lanes.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>

#include "isolux/intersect/lane_walk.h"

namespace isolux {
namespace {

template <typename T>
constexpr lanes::VoxelType kVoxelType = std::is_same_v<T, std::uint8_t>    ? lanes::VoxelType::kU8
                                        : std::is_same_v<T, std::int16_t>  ? lanes::VoxelType::kI16
                                        : std::is_same_v<T, std::uint16_t> ? lanes::VoxelType::kU16
                                                                           : lanes::VoxelType::kF32;

// The greatest |value - iso|; infinite voxels are left out, as no surface lies beside them.
double greatest_difference(const BrickGrid& bricks, double iso) {
  double greatest = 0;
  for (const BrickRange& range : bricks.ranges()) {
    for (const double value : {range.low, range.high}) {
      if (std::isfinite(value)) greatest = std::max(greatest, std::fabs(value - iso));
    }
  }
  return greatest;
}

Ray lane_ray(const RayLanes& rays, std::size_t n) {
  Ray ray;
  for (int axis = 0; axis < 3; ++axis) {
    ray.origin[axis] = rays.origin[axis][n];
    ray.direction[axis] = rays.direction[axis][n];
  }
  return ray;
}

void set_normal(HitLanes& hits, std::size_t n, Vec3 normal, Vec3 world_direction) {
  const bool turned = dot(normal, world_direction) > 0;
  if (turned) hits.turned |= 1u << n;
  for (int axis = 0; axis < 3; ++axis) {
    hits.normal[axis][n] = static_cast<float>(turned ? -normal[axis] : normal[axis]);
  }
}

}  // namespace

IsoLanes::IsoLanes(IsoSurface surface, const BrickGrid& bricks, std::size_t reach)
    : surface_(std::move(surface)),
      skip_(surface_.volume(), bricks, surface_.iso()),
      reach_(reach),
      greatest_(greatest_difference(bricks, surface_.iso())) {}

lanes::Field IsoLanes::field() const {
  const Volume& volume = surface_.volume();
  lanes::Field field{};
  visit_voxels(volume, [&]<typename T>(const VolumeView<T>& view) {
    field.type = kVoxelType<T>;
    field.voxels = view.voxels;
    field.is_wide = voxel_count(volume) * sizeof(T) >= reach_;
  });
  std::ranges::copy(volume.dims, field.dims);
  field.leaps = skip_.leaps();
  field.cells = reinterpret_cast<const std::uint32_t*>(skip_.cells());
  field.block_stride_y = static_cast<std::int32_t>(skip_.stride_y());
  field.block_stride_z = static_cast<std::int32_t>(skip_.stride_z());
  field.block_count = static_cast<std::int32_t>(skip_.size());
  field.iso = static_cast<float>(surface_.iso());
  field.iso_rest = static_cast<float>(surface_.iso() - static_cast<double>(field.iso));
  field.doubt = static_cast<float>(kDoubt * greatest_);
  for (int row = 0; row < 3; ++row) {
    for (int column = 0; column < 3; ++column) {
      field.world_from_covector[row][column] =
          static_cast<float>(surface_.world_from_covector().at(row, column));
    }
  }
  return field;
}

std::optional<IsoHit> IsoLanes::hit_of_oracle(const RayLanes& rays, std::size_t n) const {
  Ray ray = lane_ray(rays, n);
  const double begin = rays.begin[n], end = rays.end[n];
  ray.origin = ray.at(begin);
  auto hit = surface_.first_hit_in_index_space(ray, end - begin);
  if (!hit) return std::nullopt;
  hit->t += begin;
  return hit->t < end ? hit : std::nullopt;
}

void IsoLanes::walk_all(std::span<const RayLanes> rays, std::span<const std::uint32_t> lanes,
                        HitLanes* hits, std::span<lanes::Found> found) const {
  std::array<lanes::Question, kPacketsAtOnce> questions;
  for (std::size_t n = 0; n < rays.size(); ++n) {
    questions[n] = {&rays[n], lanes[n], hits ? hits + n : nullptr, &found[n]};
  }
  lanes::walk(field(), {questions.data(), rays.size()});
}

void IsoLanes::first_hits(const RayLanes& rays, std::uint32_t lanes, HitLanes& hits) const {
  lanes::Found found;
  if (rays.is_beam) {
    lanes::walk_beam(field(), rays, lanes, &hits, found);
  } else {
    walk_all({&rays, 1}, {&lanes, 1}, &hits, {&found, 1});
  }
  complete(rays, found, hits);
}

void IsoLanes::first_hits(std::span<const RayLanes> rays, std::span<const std::uint32_t> lanes,
                          std::span<HitLanes> hits) const {
  for (std::size_t first = 0; first < rays.size(); first += kPacketsAtOnce) {
    const std::size_t count = std::min(kPacketsAtOnce, rays.size() - first);
    std::array<lanes::Found, kPacketsAtOnce> found;
    walk_all(rays.subspan(first, count), lanes.subspan(first, count), &hits[first], found);
    for (std::size_t n = 0; n < count; ++n) complete(rays[first + n], found[n], hits[first + n]);
  }
}

// What the walk has left to the oracle.
void IsoLanes::complete(const RayLanes& rays, const lanes::Found& found, HitLanes& hits) const {
  hits.hit = found.hit;
  hits.turned = found.turned;
  const auto world_direction = [&](std::size_t n) {
    return surface_.volume().world_from_index.vector(lane_ray(rays, n).direction);
  };
  for (std::uint32_t rest = found.without_normal; rest != 0; rest &= rest - 1) {
    const auto n = static_cast<std::size_t>(std::countr_zero(rest));
    const IsoHit hit{hits.t[n],
                     {found.cell[0][n], found.cell[1][n], found.cell[2][n]},
                     {found.local[0][n], found.local[1][n], found.local[2][n]}};
    hits.turned &= ~(1u << n);
    set_normal(hits, n, surface_.normal(hit).value_or(Vec3{}), world_direction(n));
  }
  for (std::uint32_t rest = found.undecided; rest != 0; rest &= rest - 1) {
    const auto n = static_cast<std::size_t>(std::countr_zero(rest));
    const auto hit = hit_of_oracle(rays, n);
    if (!hit) continue;
    hits.hit |= 1u << n;
    hits.t[n] = hit->t;
    set_normal(hits, n, surface_.normal(*hit).value_or(Vec3{}), world_direction(n));
  }
}

std::uint32_t IsoLanes::occluded(const RayLanes& rays, std::uint32_t lanes) const {
  lanes::Found found;
  if (rays.is_beam) {
    lanes::walk_beam(field(), rays, lanes, nullptr, found);
  } else {
    walk_all({&rays, 1}, {&lanes, 1}, nullptr, {&found, 1});
  }
  return completed(rays, found);
}

void IsoLanes::occluded(std::span<const RayLanes> rays, std::span<std::uint32_t> lanes) const {
  for (std::size_t first = 0; first < rays.size(); first += kPacketsAtOnce) {
    const std::size_t count = std::min(kPacketsAtOnce, rays.size() - first);
    std::array<lanes::Found, kPacketsAtOnce> found;
    walk_all(rays.subspan(first, count), lanes.subspan(first, count), nullptr, found);
    for (std::size_t n = 0; n < count; ++n) lanes[first + n] = completed(rays[first + n], found[n]);
  }
}

std::uint32_t IsoLanes::completed(const RayLanes& rays, const lanes::Found& found) const {
  std::uint32_t hit = found.hit;
  for (std::uint32_t rest = found.undecided; rest != 0; rest &= rest - 1) {
    const auto n = static_cast<std::size_t>(std::countr_zero(rest));
    if (hit_of_oracle(rays, n)) hit |= 1u << n;
  }
  return hit;
}

}  // namespace isolux
