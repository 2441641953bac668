#include <algorithm>
#include <cmath>
#include <cstdint>

#include "isolux/base/exact_math.h"
#include "isolux/volume/analytic_volume.h"
#include "isolux/volume/phantom.h"

// The head is a handful of ellipsoids. Each gives a signed distance d(p) in mm, negative inside;
// bodies are joined and cut by smooth minimum and maximum, and a distance becomes a share of the
// body in a voxel by a smooth step over +-kBlur mm, as the point spread of a scanner would. Then
//   HU = air + skin (tissue - air) + bone (density - tissue) + ...
// in the order of `hounsfield` below.

namespace isolux {
namespace {

constexpr double kBlur = 1.6;  // mm

struct Ellipsoid {
  Vec3 center;
  Vec3 radii;
};

// First-order distance to an ellipsoid: exact on the surface, off by curvature away from it.
double distance(const Ellipsoid& e, Vec3 p) {
  const Vec3 q = p - e.center;
  const Vec3 unit{q.x / e.radii.x, q.y / e.radii.y, q.z / e.radii.z};
  const Vec3 slope{unit.x / e.radii.x, unit.y / e.radii.y, unit.z / e.radii.z};
  const double u = length(unit);
  return u * (u - 1) / std::max(length(slope), 1e-9);
}

// Polynomial smooth minimum over a zone of `zone` mm.
double join(double a, double b, double zone) {
  const double h = std::max(zone - std::fabs(a - b), 0.0) / zone;
  return std::min(a, b) - h * h * zone / 4;
}
double common(double a, double b, double zone) { return -join(-a, -b, zone); }
double cut(double body, double hole, double zone) { return common(body, -hole, zone); }

double share(double distance_mm) {
  const double x = std::clamp((kBlur - distance_mm) / (2 * kBlur), 0.0, 1.0);
  return x * x * (3 - 2 * x);
}

double toward(double from, double to, double part) { return from + part * (to - from); }

// The same shape on both sides of the mid-plane.
double pair(const Ellipsoid& left, Vec3 p) { return distance(left, {std::fabs(p.x), p.y, p.z}); }

const Ellipsoid kCranium{{0, 8, 36}, {75, 94, 76}};

double skin_distance(Vec3 p) {
  double d = distance(kCranium, p);
  d = join(d, distance({{0, -36, -34}, {57, 50, 66}}, p), 24);     // face
  d = join(d, distance({{0, -70, -84}, {22, 18, 17}}, p), 22);     // chin
  d = join(d, pair({{36, -62, -26}, {20, 20, 18}}, p), 18);        // cheeks
  d = join(d, pair({{24, -82, 18}, {24, 10, 7}}, p), 12);          // brow
  d = cut(d, pair({{29, -98, 2}, {15, 13, 10}}, p), 12);           // eye hollows
  d = join(d, pair({{29, -76, 2}, {12, 12, 10}}, p), 3);           // lids
  d = join(d, distance({{0, -86, -6}, {8, 12, 26}}, p), 9);        // bridge of the nose
  d = join(d, distance({{0, -97, -27}, {10, 13, 9}}, p), 8);       // tip
  d = join(d, pair({{10, -89, -29}, {7, 8, 7}}, p), 5);            // wings
  d = cut(d, pair({{5, -99, -36}, {3, 5, 4}}, p), 3);              // nostrils
  d = join(d, distance({{0, -84, -54}, {21, 10, 5}}, p), 5);       // upper lip
  d = join(d, distance({{0, -83, -64}, {18, 10, 5}}, p), 5);       // lower lip
  d = cut(d, distance({{0, -96, -59}, {22, 8, 1.6}}, p), 3);       // mouth
  double neck = distance({{0, 22, -120}, {50, 52, 120}}, p);
  d = join(d, neck, 26);
  double ear = pair({{78, 16, -2}, {9, 19, 30}}, p);
  ear = cut(ear, pair({{88, 12, 4}, {7, 11, 18}}, p), 4);
  d = join(d, ear, 5);
  return d;
}

// Grooves where the plates of the skull meet: along the mid-line and across, a little wavy.
double suture_depth(Vec3 p) {
  const double wave = 2.5 * exact::sin(p.y * 0.55) + 1.2 * exact::sin(p.y * 1.3);
  const double wave_across = 2.5 * exact::sin(p.x * 0.55) + 1.2 * exact::sin(p.x * 1.3);
  const double sagittal = p.y > -28 ? std::fabs(p.x - wave) : 1e3;
  const double coronal = std::fabs(p.y + 28 + 0.15 * std::fabs(p.x) - wave_across);
  const double nearest = p.z > 30 ? std::min(sagittal, coronal) : 1e3;
  return 2.2 * share(nearest - 1.6);
}

double bone_distance(Vec3 p) {
  const double outer = distance(kCranium, p) + 7;
  double d = outer + suture_depth(p);
  d = cut(d, distance({kCranium.center, {60, 79, 61}}, p), 2);      // room for the brain
  double face = distance({{0, -38, -28}, {47, 41, 42}}, p);
  face = join(face, pair({{40, -56, -18}, {17, 15, 9}}, p), 10);    // cheek bones
  face = join(face, pair({{26, -76, 17}, {24, 8, 6}}, p), 8);       // brow
  face = join(face, distance({{0, -76, 0}, {6, 12, 14}}, p), 6);    // nasal bones
  face = cut(face, distance({{0, -14, -40}, {30, 36, 44}}, p), 6);  // hollow behind
  face = cut(face, distance({kCranium.center, {60, 79, 61}}, p), 3);
  d = join(d, face, 8);
  d = cut(d, pair({{28, -80, 2}, {17, 24, 15}}, p), 5);             // eye sockets
  d = cut(d, distance({{0, -84, -26}, {11, 18, 15}}, p), 4);        // nasal opening
  double jaw = distance({{0, -28, -74}, {50, 50, 17}}, p);
  jaw = cut(jaw, distance({{0, -18, -70}, {39, 48, 40}}, p), 4);
  double ramus = pair({{48, -10, -44}, {6, 15, 38}}, p);
  jaw = join(jaw, ramus, 8);
  d = join(d, jaw, 2);
  double teeth = distance({{0, -40, -58}, {27, 37, 13}}, p);
  teeth = cut(teeth, distance({{0, -30, -58}, {22, 37, 40}}, p), 2);
  teeth = cut(teeth, std::fabs(p.z + 59) - 1.1, 1.5);
  d = join(d, teeth, 1.5);
  d = join(d, distance({{0, 30, -110}, {17, 14, 74}}, p), 6);       // spine
  return d;
}

double hounsfield(Vec3 p) {
  constexpr double kAir = -1000, kTissue = 40, kBrain = 35, kFluid = 5;
  constexpr double kSpongy = 750, kDense = 1350;
  const double skin = skin_distance(p);
  const double bone = common(bone_distance(p), skin + 2, 2);  // never through the skin
  double hu = toward(kAir, kTissue, share(skin));
  const double brain = distance({kCranium.center, {57, 76, 58}}, p);
  hu = toward(hu, kFluid, share(brain - 3));
  const double folds = exact::sin(p.x * 0.35) * exact::sin(p.y * 0.3) * exact::sin(p.z * 0.38);
  hu = toward(hu, kBrain + 8 * folds, share(brain));
  // Bone is dense outside and spongy 3 mm deep.
  hu = toward(hu, toward(kDense, kSpongy, share(bone + 3)), share(bone));
  const double air_ways = distance({{0, -40, -34}, {9, 30, 12}}, p);
  hu = toward(hu, kAir, share(common(air_ways, -bone, 1)));
  const double bead = distance({{92, 14, -24}, {9, 9, 9}}, p);  // the mark, on the left ear
  return toward(hu, 1500, share(bead));
}

}  // namespace

Volume head_phantom(int size) {
  Volume volume = sample_on_cube<std::int16_t>(size, 127.5, hounsfield);
  volume.modality = "CT";
  volume.units = "HU";
  return volume;
}

}  // namespace isolux
