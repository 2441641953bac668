#pragma once

#include "isolux/base/rgb.h"
#include "isolux/base/vec3.h"
#include "isolux/shade/light.h"
#include "isolux/shade/material.h"

// The reflection model of the lecture: ambient + sum over lights of Lambert's and Phong's terms,
// for each colour channel apart. It sees vectors only, no geometry and no pixels.

namespace isolux {

/// One point of a surface as the reflection model sees it, in world space.
struct SurfacePoint {
  Vec3 position;  ///< mm
  Vec3 normal;    ///< unit, turned towards the eye: normal . to_eye >= 0
  Vec3 to_eye;    ///< unit
};

/// What one light adds at a point, and every quantity on the way there.
struct LightTerms {
  Vec3 offset;  ///< from the point to a point light (P - p), mm; directional: the vector given
  double distance = 0;   ///< length of `offset`
  Vec3 to_light;         ///< l, the unit vector along `offset`; zero if the light is at the point
  Vec3 reflected;        ///< r = 2 (n . l) n - l
  double cos_theta = 0;  ///< n . l, not clamped
  double cos_phi = 0;    ///< r . e, not clamped
  double falloff = 1;
  double phong = 0;       ///< max(0, r . e)^shininess where n . l > 0, else 0
  double visibility = 1;  ///< V: the share of the light that shadows leave
  Rgb diffuse;            ///< kd * I * max(0, n . l) * V * falloff
  Rgb specular;           ///< ks * I * phong * V * falloff
};

LightTerms light_terms(const Material& material, const Light& light, const SurfacePoint& point,
                       double visibility = 1);

/// I * max(0, n . l) * falloff: what a light brings to a point when nothing is in its way.
Rgb irradiance(const Light& light, const SurfacePoint& point);

/// ka * Ia.
Rgb ambient_term(const Material& material, Rgb ambient_light);

}  // namespace isolux
