#include "isolux/render/blend_finder.h"

#include <algorithm>
#include <bit>
#include <cmath>

#include "isolux/mesh/mesh_attributes.h"

namespace isolux {
namespace {

using Floats = BlendPoints::Floats;
constexpr std::size_t kMost = BlendPoints::kCount;

std::size_t number_of(SeenSide side) { return (side.inside ? 2u : 0u) + (side.flipped ? 1u : 0u); }
SeenSide side_of(std::size_t number) { return {(number & 2) != 0, (number & 1) != 0}; }

}  // namespace

void BlendFinder::find(const Places& places, std::uint32_t mask, double together,
                       std::vector<BlendShare>& shares) {
  std::array<Met, kCount> all;
  for (std::uint32_t rest = mask; rest != 0; rest &= rest - 1) {
    const auto n = static_cast<std::size_t>(std::countr_zero(rest));
    const auto [x, y] = buffer_.pixel(places[n]);
    const Ray ray = scene_.camera->ray(x, y);
    const SurfaceSample sample = buffer_.sample(places[n]);
    all[n] =
        met(sample.surface, ray.at(sample.depth_mm), sample.normal(), -ray.direction, sample.point);
  }
  while (mask != 0) {
    const auto first = static_cast<std::size_t>(std::countr_zero(mask));
    begin(buffer_.surface[places[first]], all[first]);
    for (std::uint32_t rest = mask; rest != 0; rest &= rest - 1) {
      const auto n = static_cast<std::size_t>(std::countr_zero(rest));
      if (buffer_.surface[places[n]] == points_.surface && all[n].sheet == points_.sheet &&
          length(all[n].in_blocks - points_.origin) <= together) {
        set(n, all[n]);
      }
    }
    mask &= ~points_.mask;
    weigh();
    share_out(shares);
  }
}

void BlendFinder::find(const FurtherPoint& point, std::vector<BlendWeight>& weights) {
  const auto& [nx, ny, nz] = point.normal;
  const auto& [ex, ey, ez] = point.to_eye;
  const Met at = met(point.surface, point.position, {nx, ny, nz}, {ex, ey, ez}, point.point);
  begin(point.surface, at);
  set(0, at);
  weigh();
  for (const SiteWeights& sample : samples_found_) {
    weights.push_back({sample.which, sample.weight[0] / sums_[0]});
  }
}

BlendFinder::Met BlendFinder::met(std::int32_t surface, Vec3 position, Vec3 normal, Vec3 to_eye,
                                  const MeshPoint& point) const {
  const PreparedSurface& of = surfaces_.at(surface);
  const Vec3 out = of.mesh() ? shading_normal(*of.mesh(), point)
                             : of.true_normal(position, point).value_or(normal);
  const bool turned = dot(out, normal) < 0;
  const Vec3 outward = turned ? -normal : normal;
  const bool inside =
      of.mesh() ? is_inside(of, position, point, outward, -to_eye) : dot(out, to_eye) < 0;
  return {samples_.in_blocks(surface, position),
          outward,
          {inside, turned != inside},
          samples_.sheet(surface, point)};
}

void BlendFinder::begin(std::int32_t surface, const Met& first) {
  points_.mask = 0;
  points_.surface = surface;
  points_.sheet = first.sheet;
  points_.origin = first.in_blocks;
  of_side_ = {};
}

void BlendFinder::set(std::size_t n, const Met& at) {
  const Vec3f from_origin = as_float(at.in_blocks - points_.origin);
  points_.x[n] = from_origin.x;
  points_.y[n] = from_origin.y;
  points_.z[n] = from_origin.z;
  const Vec3f outward = as_float(at.outward);
  points_.normal_x[n] = outward.x;
  points_.normal_y[n] = outward.y;
  points_.normal_z[n] = outward.z;
  const Vec3f across = as_float(samples_.normal_in_blocks(points_.surface, at.outward));
  points_.across_x[n] = across.x;
  points_.across_y[n] = across.y;
  points_.across_z[n] = across.z;
  points_.mask |= 1u << n;
  of_side_[number_of(at.side)] |= 1u << n;
}

// Finds the samples that count, and the sums of their weights, which are not 0 where a sample is
// anywhere near.
void BlendFinder::weigh() {
  const auto first = static_cast<std::size_t>(std::countr_zero(points_.mask));
  for (std::uint32_t rest = 0xFFFF & ~points_.mask; rest != 0; rest &= rest - 1) {
    const auto n = static_cast<std::size_t>(std::countr_zero(rest));
    for (auto* of : {&points_.x, &points_.y, &points_.z, &points_.normal_x, &points_.normal_y,
                     &points_.normal_z, &points_.across_x, &points_.across_y, &points_.across_z}) {
      (*of)[n] = (*of)[first];
    }
  }
  BlockIndex low, high;
  const auto range = [&](const Floats& of, double origin, std::size_t axis) {
    const auto [least, most] = std::ranges::minmax(of);
    low[axis] =
        static_cast<std::int32_t>(std::floor(origin + static_cast<double>(least - kBlendReach)));
    high[axis] =
        static_cast<std::int32_t>(std::floor(origin + static_cast<double>(most + kBlendReach)));
  };
  range(points_.x, points_.origin.x, 0);
  range(points_.y, points_.origin.y, 1);
  range(points_.z, points_.origin.z, 2);
  near_.clear();
  samples_.each_site(points_.surface, low, high,
                     [&](std::uint32_t site) { near_.push_back(site); });
  sites_found_.clear();
  weigh_sites(points_, samples_.sites().data(), near_, sites_found_);
  samples_found_.clear();
  sums_.fill(0);
  for (const SiteWeights& site : sites_found_) {
    for (std::size_t side = 0; side < of_side_.size(); ++side) {
      const std::uint32_t lanes = site.lanes & of_side_[side];
      if (lanes != 0) add(samples_.sample(site.which, side_of(side)), lanes, site.weight);
    }
  }
  constexpr float kLeast = 1e-3f;
  for (std::uint32_t rest = points_.mask; rest != 0; rest &= rest - 1) {
    const auto n = static_cast<std::size_t>(std::countr_zero(rest));
    if (sums_[n] < kLeast) stand_in(n, kLeast);
  }
}

void BlendFinder::add(std::uint32_t sample, std::uint32_t lanes, const Floats& weight) {
  SiteWeights& to = samples_found_.emplace_back(SiteWeights{sample, lanes, weight});
  for (std::size_t n = 0; n < kMost; ++n) {
    to.weight[n] = (lanes >> n & 1) != 0 ? weight[n] : 0;
    sums_[n] += to.weight[n];
  }
}

// Where nothing near is like a point, what is least unlike it stands in for the rest.
void BlendFinder::stand_in(std::size_t n, float least) {
  const Vec3 at = points_.origin + Vec3{points_.x[n], points_.y[n], points_.z[n]};
  const Vec3 outward{points_.normal_x[n], points_.normal_y[n], points_.normal_z[n]};
  const auto side =
      std::ranges::find_if(of_side_, [n](std::uint32_t lanes) { return (lanes >> n & 1) != 0; });
  const std::uint32_t sample =
      samples_.find_in_blocks(points_.surface, at, points_.sheet, outward,
                              side_of(static_cast<std::size_t>(side - of_side_.begin())));
  if (sample == SurfaceSamples::kNone) return;
  Floats weight{};
  weight[n] = least - sums_[n];
  add(sample, 1u << n, weight);
}

void BlendFinder::share_out(std::vector<BlendShare>& shares) const {
  Floats scale, most{};
  std::array<std::int32_t, kMost> left{}, greatest{};
  for (std::size_t n = 0; n < kMost; ++n) {
    left[n] = sums_[n] > 0 ? BlendShare::kWhole : 0;
    scale[n] = sums_[n] > 0 ? BlendShare::kWhole / sums_[n] : 0;
  }
  const std::size_t begin = shares.size();
  for (const SiteWeights& sample : samples_found_) {
    BlendShare& share = shares.emplace_back(BlendShare{sample.which, {}});
    const auto number = static_cast<std::int32_t>(shares.size() - 1 - begin);
    int all = 0;
    for (std::size_t n = 0; n < kMost; ++n) {
      const auto part = static_cast<std::int32_t>(sample.weight[n] * scale[n]);  // rounds down
      share.weight[n] = static_cast<std::uint16_t>(part);
      left[n] -= part;
      all |= part;
      greatest[n] = sample.weight[n] > most[n] ? number : greatest[n];
      most[n] = std::max(most[n], sample.weight[n]);
    }
    if (all == 0) shares.pop_back();
  }
  // What rounding has left belongs to the greatest.
  for (std::uint32_t rest = points_.mask; rest != 0; rest &= rest - 1) {
    const auto n = static_cast<std::size_t>(std::countr_zero(rest));
    if (left[n] == 0) continue;
    std::uint16_t& weight = shares[begin + static_cast<std::size_t>(greatest[n])].weight[n];
    weight = static_cast<std::uint16_t>(weight + left[n]);
  }
}

}  // namespace isolux
