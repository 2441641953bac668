#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "isolux/render/surface_samples.h"
#include "isolux/scene/scene.h"

namespace isolux {

struct LinkRays;

/// What surface samples see: for each, links to the samples (of another set, mostly coarser) that
/// rays from it meet, or to the open sky. Rays go by the cosine about the shading normal, so the
/// mean of what the links lead to is the integral of the contract's indirect light.
///
/// Rays are Sobol points keyed by sample and link: a sample's links are the same whenever and with
/// whichever others they are shot, and the first 2^n are spread evenly for every n. A ray passes a
/// surface of opacity A with probability 1 - A.
class TransportLinks {
 public:
  /// Keeps references to the surfaces and the samples.
  TransportLinks(const Scene& scene, const SceneSurfaces& surfaces, const SurfaceSamples& from,
                 const SurfaceSamples& to);

  /// A link's number for the open sky, and for a place that no sample stands for, which is dark;
  /// lower numbers are samples.
  std::uint32_t sky() const { return static_cast<std::uint32_t>(to_.size()); }
  std::uint32_t dark() const { return sky() + 1; }

  /// Shoots rays until each of `samples` has at least `count` links, on all threads.
  void shoot(std::span<const std::uint32_t> samples, std::size_t count);

  /// Forgets the links of all samples but these, which are in order.
  void keep(std::span<const std::uint32_t> samples);

  std::span<const std::uint32_t> of(std::uint32_t sample) const { return rows_[sample]; }

  double bytes() const;
  /// Of that, what links take.
  double link_bytes() const;

 private:
  void shoot_piece(std::span<const std::uint32_t> samples, std::size_t count);
  void trace(LinkRays& rays);

  const SceneSurfaces& surfaces_;
  const SurfaceSamples& from_;
  const SurfaceSamples& to_;
  std::vector<double> opacities_;
  std::vector<std::vector<std::uint32_t>> rows_;
};

}  // namespace isolux
