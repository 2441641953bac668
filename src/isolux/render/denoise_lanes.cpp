#define HWY_DISABLED_TARGETS HWY_SSSE3
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "isolux/render/denoise_lanes.cpp"
#include <hwy/foreach_target.h>
// Highway compiles what follows once for each instruction set.
#include <hwy/highway.h>

#include "isolux/render/denoise_pass.h"

HWY_BEFORE_NAMESPACE();
namespace isolux::denoising::HWY_NAMESPACE {
namespace {

namespace hn = hwy::HWY_NAMESPACE;

constexpr hn::CappedTag<float, kMostLanes> kF;
using VF = hn::Vec<decltype(kF)>;

struct Vector {
  VF x, y, z;
};

HWY_INLINE VF all(float value) { return hn::Set(kF, value); }
HWY_INLINE Vector all(const float (&v)[3]) { return {all(v[0]), all(v[1]), all(v[2])}; }
HWY_INLINE VF dot(const Vector& a, const Vector& b) {
  return hn::MulAdd(a.z, b.z, hn::MulAdd(a.y, b.y, hn::Mul(a.x, b.x)));
}
HWY_INLINE Vector plus(const Vector& a, const Vector& b, VF times) {
  return {hn::MulAdd(b.x, times, a.x), hn::MulAdd(b.y, times, a.y), hn::MulAdd(b.z, times, a.z)};
}

HWY_INLINE Vector direction(const Rays& rays, int x, int y) {
  if (rays.is_orthographic) return all(rays.first);
  const hn::RebindToSigned<decltype(kF)> kI;
  const VF across = hn::ConvertTo(kF, hn::Iota(kI, x));
  return plus(plus(all(rays.first), all(rays.along_x), across), all(rays.along_y),
              all(static_cast<float>(y)));
}

// How far taps lie from a pixel's tangent plane, in widths of a pixel there: n . (q - p). As q is a
// depth times a direction (with parallel rays: an origin and a depth) that is linear in the pixel,
// so is the rest, and of a tap its depth alone is read.
struct TangentPlane {
  VF own, across, along_x, along_y;
  bool is_orthographic;

  HWY_INLINE TangentPlane(const Pass& pass, const Vector& normal, VF depth, int x, int y)
      : is_orthographic(pass.rays->is_orthographic) {
    const Rays& rays = *pass.rays;
    const VF width = is_orthographic ? all(rays.pixel_size) : hn::Mul(all(rays.pixel_size), depth);
    const VF scale = hn::Div(all(1.0f), width);
    const VF scaled_step = hn::Mul(scale, all(static_cast<float>(pass.step)));
    across = hn::Mul(scale, dot(normal, direction(rays, x, y)));
    along_x = hn::Mul(scaled_step, dot(normal, all(rays.along_x)));
    along_y = hn::Mul(scaled_step, dot(normal, all(rays.along_y)));
    own = hn::Mul(across, depth);
  }

  HWY_INLINE VF distance(const Tap& tap, VF depth) const {
    const VF aside = hn::MulAdd(all(static_cast<float>(tap.dy)), along_y,
                                hn::Mul(all(static_cast<float>(tap.dx)), along_x));
    return is_orthographic ? hn::Add(hn::MulSub(depth, across, own), aside)
                           : hn::MulSub(depth, hn::Add(across, aside), own);
  }
};

// Taps count for (1 - |dn|^2 - (distance from the tangent plane / reach)^2)^2 where that is more
// than 0. The reach grows with the root of the step, for surfaces bend.
constexpr float kReach = 2;  // pixels' widths

template <bool kFirst, bool kLast>
void filter_row(const Pass& pass, int y) {
  const Guide& guide = *pass.guide;
  const VF zero = hn::Zero(kF), one = all(1.0f);
  const VF per_plane = all(1 / (kReach * kReach * static_cast<float>(pass.step)));
  std::ptrdiff_t offsets[kTapCount];
  for (int t = 0; t < kTapCount; ++t) {
    offsets[t] = pass.step * (kTaps[t].dy * guide.key.stride() + kTaps[t].dx);
  }
  for (int x = 0; x < guide.width; x += static_cast<int>(hn::Lanes(kF))) {
    const auto at = [&](const Plane& plane) HWY_ATTR { return plane.row(y) + x; };
    const VF key = hn::LoadU(kF, at(guide.key));
    if (hn::AllTrue(kF, hn::Eq(key, all(Guide::kNothing)))) continue;
    const VF surfaces = hn::Round(hn::Mul(key, all(1 / Guide::kApart)));
    const Vector normal{hn::NegMulAdd(surfaces, all(Guide::kApart), key),
                        hn::LoadU(kF, at(guide.normal_y)), hn::LoadU(kF, at(guide.normal_z))};
    const TangentPlane plane(pass, normal, hn::LoadU(kF, at(guide.depth)), x, y);

    VF weights = zero, squares = zero, variance = zero, energy = zero, noise = zero;
    VF sum[3] = {zero, zero, zero};
    const float* const keys = at(guide.key);
    const float* const normals_y = at(guide.normal_y);
    const float* const normals_z = at(guide.normal_z);
    const float* const depths = at(guide.depth);
    const float* const variances = kLast ? nullptr : at(*pass.variance);
    const float* const colors[3] = {at(pass.level->r), at(pass.level->g), at(pass.level->b)};
    const float* const energies = kFirst ? nullptr : at(*pass.energy);
    const float* const noises = kFirst ? nullptr : at(*pass.noise);
    for (int t = 0; t < kTapCount; ++t) {
      const auto there = [&](const float* from)
                             HWY_ATTR { return hn::LoadU(kF, from + offsets[t]); };
      const Vector turn{hn::Sub(there(keys), key), hn::Sub(there(normals_y), normal.y),
                        hn::Sub(there(normals_z), normal.z)};
      const VF off = plane.distance(kTaps[t], there(depths));
      const VF apart = hn::MulAdd(hn::Mul(off, off), per_plane, dot(turn, turn));
      const VF near = hn::Max(hn::Sub(one, apart), zero);
      const VF weight = hn::Mul(hn::Mul(near, near), all(kTaps[t].weight));
      weights = hn::Add(weights, weight);
      if constexpr (!kLast) {
        squares = hn::MulAdd(weight, weight, squares);
        variance = hn::MulAdd(weight, there(variances), variance);
        for (int c = 0; c < 3; ++c) {
          sum[c] = hn::MulAdd(weight, there(colors[c]), sum[c]);
        }
      }
      if constexpr (!kFirst) {
        energy = hn::MulAdd(weight, there(energies), energy);
        noise = hn::MulAdd(weight, there(noises), noise);
      }
    }

    const VF share = hn::Div(one, weights);
    // Of the detail before, what is noise: 0 to 1. Not asked where there is none, nor detail.
    VF taken = zero;
    if constexpr (!kFirst) {
      const VF expected = hn::Mul(noise, all(pass.strength));
      const VF least = all(1e-30f);
      taken = hn::IfThenElseZero(hn::Gt(expected, least),
                                 hn::Div(hn::Min(expected, energy), hn::Max(energy, least)));
    }
    VF detail = zero;
    for (int c = 0; c < 3; ++c) {
      const VF now = hn::LoadU(kF, at(pass.level->at(c)));
      if constexpr (!kFirst) {
        const VF before = hn::Sub(hn::LoadU(kF, at(pass.before->at(c))), now);
        const VF result = hn::LoadU(kF, at(pass.result_before->at(c)));
        hn::StoreU(hn::NegMulAdd(taken, before, result), kF, pass.result->at(c).row(y) + x);
      }
      if constexpr (!kLast) {
        const VF next = hn::Mul(sum[c], share);
        detail = hn::Add(detail, hn::Sub(now, next));
        hn::StoreU(next, kF, pass.before->at(c).row(y) + x);
      }
    }
    if constexpr (!kLast) {
      detail = hn::Mul(detail, all(1.0f / 3));
      const VF square = hn::Mul(detail, detail);
      // What is left of a variance of 1: fewer taps leave more of it, and depend less on each
      // other.
      const VF left = hn::Mul(squares, hn::Mul(share, share));
      const VF correlation = hn::MulAdd(all((pass.gains.correlation - 1) / (1 - pass.gains.taps)),
                                        hn::Sub(one, left), one);
      VF around = hn::Mul(variance, share);
      VF next = hn::Mul(around, hn::Mul(left, correlation));
      VF expected = hn::Mul(all(pass.gains.detail), hn::Sub(around, next));
      if constexpr (kFirst) {
        // A pixel's own share in the mean over independent ones.
        const VF own = hn::Mul(all(kTaps[0].weight), share);
        const VF of_1 = hn::Add(hn::NegMulAdd(all(2.0f), own, one), left);
        if (pass.has_variance) {
          expected = hn::Mul(around, of_1);
        } else {
          const auto is_mean = hn::Gt(of_1, all(1e-3f));
          around = hn::IfThenElseZero(is_mean, hn::Div(square, hn::Max(of_1, all(1e-3f))));
          next = hn::Mul(around, left);
          expected = square;
        }
      }
      hn::StoreU(next, kF, pass.next_variance->row(y) + x);
      hn::StoreU(square, kF, pass.next_energy->row(y) + x);
      hn::StoreU(expected, kF, pass.next_noise->row(y) + x);
    }
  }
}

void filter_rows(const Pass& pass, std::span<const int> rows) {
  for (const int y : rows) {
    if (!pass.energy) {
      filter_row<true, false>(pass, y);
    } else if (pass.next_energy) {
      filter_row<false, false>(pass, y);
    } else {
      filter_row<false, true>(pass, y);
    }
  }
}

void flatten_rows(const Rays& rays, Guide& guide, int begin, int end) {
  for (int y = begin; y < end; ++y) {
    for (int x = 0; x < guide.width; x += static_cast<int>(hn::Lanes(kF))) {
      const Vector along = direction(rays, x, y);
      const VF key = hn::LoadU(kF, guide.key.row(y) + x);
      float* const to = guide.depth.row(y) + x;
      const VF depth = hn::Div(hn::LoadU(kF, to), hn::Sqrt(dot(along, along)));
      hn::StoreU(hn::IfThenElse(hn::Eq(key, all(Guide::kNothing)), all(1.0f), depth), kF, to);
    }
  }
}

}  // namespace
}  // namespace isolux::denoising::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace isolux::denoising {

HWY_EXPORT(filter_rows);
HWY_EXPORT(flatten_rows);

void filter(const Pass& pass, std::span<const int> rows) {
  HWY_DYNAMIC_DISPATCH(filter_rows)(pass, rows);
}

void flatten(const Rays& rays, Guide& guide, int begin, int end) {
  HWY_DYNAMIC_DISPATCH(flatten_rows)(rays, guide, begin, end);
}

}  // namespace isolux::denoising
#endif
