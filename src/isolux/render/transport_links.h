#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "isolux/render/link_tracer.h"
#include "isolux/render/surface_samples.h"
#include "isolux/scene/scene.h"

namespace isolux {

/// Across the normal of the sample that sent a link: the link's direction in the tangent frame, in
/// whole steps, so that sums of it are exact.
struct LinkTilt {
  static constexpr double kStep = 1.0 / 16384;

  std::int32_t across = 0, along = 0;

  void add(const LinkTilt& other) {
    across += other.across;
    along += other.along;
  }
};

/// What a ray from a sample has met: another sample.
struct Link {
  std::uint32_t to;
  std::int16_t across, along;  ///< see LinkTilt

  LinkTilt tilt() const { return {across, along}; }
};

/// What a sample sees. Rays that meet the open sky, or a place that no sample stands for, which is
/// dark, are only counted.
struct SampleLinks {
  std::vector<Link> links;
  std::vector<std::uint16_t> close;  ///< numbers of those that are so: see SurfaceSamples::close_mm
  std::int32_t rays = 0;             ///< all that were shot
  std::int32_t sky = 0;              ///< those that met nothing
  LinkTilt all_tilt, sky_tilt;       ///< their sums
};

/// What surface samples see: for each, links to the samples (of another set, mostly coarser) that
/// rays from it meet. Rays go by the cosine about the shading normal, so the mean of what they lead
/// to is the integral of the contract's indirect light.
///
/// Directions are Sobol points in the tangent frame, the same ones for one sample in eight, so that
/// rays which go together go the same way, and those of blocks side by side fill each other's gaps.
/// A sample's links are the same whenever and with whichever others they are shot, and the first
/// 2^n are spread evenly for every n.
class TransportLinks {
 public:
  /// Keeps references to the surfaces and the samples. `most`: links that a sample can have, a
  /// power of 2.
  TransportLinks(const Scene& scene, const SceneSurfaces& surfaces, const SurfaceSamples& from,
                 const SurfaceSamples& to, int most);

  /// Shoots rays until each of `samples` has sent at least `count`, on all threads.
  void shoot(std::span<const std::uint32_t> samples, std::size_t count);

  /// Forgets the links of all samples but these, which are in order, and all of those that have
  /// more than `most` rays.
  void keep(std::span<const std::uint32_t> samples, int most);

  const SampleLinks& of(std::uint32_t sample) const { return rows_[row_of_[sample]]; }
  /// Has the processor fetch what `of` will give.
  void fetch(std::uint32_t sample) const {
    constexpr std::size_t kLinksALine = 64 / sizeof(Link);
    const std::vector<Link>& links = of(sample).links;
    for (std::size_t n = 0; n < links.size(); n += kLinksALine) __builtin_prefetch(&links[n]);
  }

  /// What finds where they lead to.
  const LinkTracer& tracer() const { return tracer_; }

  double bytes() const;
  /// Of that, what links take.
  double link_bytes() const;

 private:
  static constexpr std::uint32_t kSlots = 8;

  void shoot_piece(std::span<const std::uint32_t> samples, std::size_t count);
  std::size_t links_of(std::span<const std::uint32_t> samples) const;
  std::uint32_t slot(std::uint32_t sample) const;

  const SceneSurfaces& surfaces_;
  const SurfaceSamples& from_;
  LinkTracer tracer_;
  std::size_t most_;
  std::vector<Vec3> directions_;       // [slot * most + number], in the tangent frame
  std::vector<std::uint32_t> row_of_;  // [sample]; 0: it has none
  std::vector<SampleLinks> rows_;      // the first is empty
  std::size_t links_ = 0;              // of all rows, with what is set aside for them
};

}  // namespace isolux
