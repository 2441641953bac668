#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "isolux/render/surface_buffer.h"
#include "isolux/scene/scene.h"
#include "isolux/shade/reflection.h"

namespace isolux {

/// Radiance in three float channels.
struct RgbLayer {
  std::vector<float> r, g, b;

  explicit RgbLayer(std::size_t pixels) : r(pixels), g(pixels), b(pixels) {}
  /// Rounds to floats. Not inline: where g++ 12 sees doubles made floats and doubles again, it
  /// forgets the rounding of the first two of three (a fault in its vectorizer).
  void set(std::size_t pixel, Rgb value);
  Rgb at(std::size_t pixel) const { return {r[pixel], g[pixel], b[pixel]}; }
  float* channel(int c) { return (c == 0 ? r : c == 1 ? g : b).data(); }
  const float* channel(int c) const { return (c == 0 ? r : c == 1 ? g : b).data(); }
};

/// The terms of the reflection model for each pixel, kept apart, in the order of a SurfaceBuffer; 0
/// where nothing is met. Of translucent layers each term is the sum with the layers' weights.
struct Radiance {
  RgbLayer ambient;
  RgbLayer indirect;  ///< in place of the ambient term, where the scene asks for it
  RgbLayer diffuse;
  RgbLayer specular;
  RgbLayer mirror;
  RgbLayer total;  ///< their sum, and the background as far as it is seen

  explicit Radiance(std::size_t pixels)
      : ambient(pixels),
        indirect(pixels),
        diffuse(pixels),
        specular(pixels),
        mirror(pixels),
        total(pixels) {}
};

/// The terms of one point, before they are rounded to floats, but for what a mirror there shows.
struct PointTerms {
  SurfacePoint point;
  Rgb ambient;
  Rgb irradiance;  ///< E, where there is indirect light
  Rgb indirect;    ///< kd E
  std::vector<LightTerms> lights;
  Rgb diffuse;   ///< sum over lights
  Rgb specular;  ///< sum over lights
  Rgb total;
};

/// Lights one point of surface number `surface` (at `on_mesh`, if it is a mesh), into `terms`,
/// whose list of lights is used again. `shares`: how much of each light its shadows leave; empty:
/// all. Explanations tell these numbers; pictures have them from `relight`, which does the same in
/// lanes of floats.
void light_point(const Scene& scene, std::int32_t surface, const MeshPoint& on_mesh,
                 const SurfacePoint& point, std::span<const float> shares, const Rgb* irradiance,
                 PointTerms& terms);

/// The point that an eye ray has met.
SurfacePoint point_of(const Ray& eye_ray, const SurfaceSample& sample);
/// A further point of a pixel that is not the background.
SurfacePoint point_of(const FurtherPoint& further);

}  // namespace isolux
