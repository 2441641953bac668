#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "isolux/render/ray_packet.h"
#include "isolux/render/scene_surfaces.h"
#include "isolux/render/surface_samples.h"
#include "isolux/scene/scene.h"

namespace isolux {

/// Rays that go together, each for one link, and what they have met.
struct LinkRays {
  static constexpr int kLanes = RayPacket::kCount;
  static constexpr int kPackets = IsoLanes::kPacketsAtOnce;
  static constexpr int kCount = kPackets * kLanes;

  std::array<RayPacket, kPackets> packets{};
  int count = 0;
  float reach_mm[kCount];
  // The surface that each has left, on which side of it, and two numbers that tell it from others.
  std::int32_t surface[kCount];
  bool inside[kCount];
  std::uint32_t seed[kCount], number[kCount];

  void set(int n, const Ray& ray) { packets[packet_of(n)].set(n % kLanes, ray); }
  Ray ray(int n) const { return packets[packet_of(n)].ray(n % kLanes); }
  static std::size_t packet_of(int n) { return static_cast<std::size_t>(n / kLanes); }

  std::uint32_t to[kCount];  ///< a sample, kSky or kDark
  double distance_mm[kCount];

  static constexpr std::uint32_t kSky = ~0u;        ///< nothing within reach
  static constexpr std::uint32_t kDark = kSky - 1;  ///< a place that no sample stands for
};

/// Follows the rays of links to what they meet: samples that stand for places of the surfaces. A
/// ray passes a surface of opacity A with probability 1 - A.
class LinkTracer {
 public:
  /// Where rays start, in the surface's own steps off it: far enough for the floats of lanes to see
  /// the right side.
  static constexpr double kOff = 10;

  /// Keeps references to the surfaces and the samples.
  LinkTracer(const Scene& scene, const SceneSurfaces& surfaces, const SurfaceSamples& to);

  /// Answers the first `count` rays, of unit direction.
  void trace(LinkRays& rays) const;

 private:
  bool passes(LinkRays& rays, const PacketHits& hits, int n, std::uint32_t passed) const;
  std::uint32_t met(const LinkRays& rays, PacketHits& hits, int n, bool has_passed) const;

  const SceneSurfaces& surfaces_;
  const SurfaceSamples& to_;
  std::vector<double> opacities_;
};

}  // namespace isolux
