#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "isolux/base/progress.h"
#include "isolux/render/ray_packet.h"
#include "isolux/render/scene_surfaces.h"
#include "isolux/render/surface_buffer.h"
#include "isolux/shade/light.h"

namespace isolux {

/// Which share V of each light comes through to each point of a SurfaceBuffer, in [0, 1]; 1 where
/// the shading normal faces away from the light. Empty where there are no shadows.
struct Shadows {
  std::vector<std::vector<float>> pixels;   ///< [light][place in the buffer]
  std::vector<std::vector<float>> further;  ///< [tile][light * points of the tile + point]

  bool empty() const { return pixels.empty(); }
  /// The shares of all lights at a pixel, and at a further point; empty where there are no shadows.
  std::vector<float> of_pixel(std::size_t place) const;
  std::vector<float> of_further(std::size_t tile, std::size_t point) const;
};

/// Points of surfaces, side by side.
struct PointPacket {
  static constexpr int kCount = RayPacket::kCount;

  Vec3 position[kCount];   ///< mm
  Vec3 normal[kCount];     ///< unit, as lit
  Vec3 to_eye[kCount];     ///< unit, back along the ray that met it
  double came_mm[kCount];  ///< length of that ray
  std::int32_t surface[kCount];
  MeshPoint point[kCount];
};

/// What is known already of the rays of a packet to a light, of one surface: those that it hides,
/// and of the others those that it meets nearer than its local size.
struct KnownHits {
  std::uint32_t far = 0;
  std::uint32_t near = 0;
};

/// Points that ask what comes through to them from a light.
struct ShadowQuestion {
  const PointPacket* points;
  std::uint32_t lanes;
  std::span<const KnownHits> known = {};  ///< of each surface that is_known tells; or empty
  /// The answer: the product of 1 - opacity over all crossings on the way; 1 of other lanes.
  float share[PointPacket::kCount];
};

/// Sends shadow rays to lights.
///
/// They start on the ray that met the point, a little before it: on the side that it came from, and
/// through nothing that it did not pass already. What the surface itself crosses within a voxel's
/// diagonal (or a triangle's longest edge) is looked at once more in doubles, from a start that is
/// off the surface by the error of the hit alone; and is ignored where the surface itself faces
/// away from the light, though its shading normal does not (the shadow terminator).
class ShadowRays {
 public:
  /// A smaller share counts as nothing.
  static constexpr float kLeastShare = 1e-6f;

  /// Neither argument is copied.
  ShadowRays(const Scene& scene, const SceneSurfaces& surfaces);

  /// Answers the questions; many together are quicker.
  void reach(const Light& light, std::span<ShadowQuestion> questions) const;

  /// Sets all shares, if what is known is enough for that: all surfaces, and none of them near.
  bool tells_all(std::span<const KnownHits> known, float (&share)[PointPacket::kCount]) const;

  /// Opaque meshes find shadows quicker for many points at once: see MeshSurface::find_shadows.
  bool is_known(std::size_t surface) const;
  /// Sets the rays of up to 32 points to a light into two packets for surface `number`.
  void set_packets(const Light& light, const PointPacket& points, std::uint32_t lanes,
                   std::int32_t number, ShadowPacket* packets) const;

 private:
  struct Aim;

  Aim aim(const Light& light, const PointPacket& points, std::uint32_t wanted,
          RayPacket& rays) const;
  void reach_few(const Light& light, std::span<ShadowQuestion> questions) const;
  static void dim(const PreparedSurface& surface, std::int32_t number, double opacity,
                  const RayPacket& rays, std::uint32_t lanes, float (&share)[PointPacket::kCount]);
  bool hides_itself(const Light& light, const PointPacket& points, int n) const;

  const Scene& scene_;
  const SceneSurfaces& surfaces_;
};

/// All points of a buffer, on all threads, if the scene asks for shadows.
void cast_shadows(const Scene& scene, const SceneSurfaces& surfaces, const SurfaceBuffer& buffer,
                  Shadows& shadows, const ProgressListener& listener = {});

}  // namespace isolux
