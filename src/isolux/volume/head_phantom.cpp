#include <algorithm>
#include <cmath>
#include <cstdint>
#include <initializer_list>

#include "isolux/base/exact_math.h"
#include "isolux/volume/analytic_volume.h"
#include "isolux/volume/phantom.h"

// The head is modelled like clay: ellipsoids and tapering rods, in LPS millimetres, are added to
// and carved from a body with rounded joins, which gives a signed distance in mm, negative inside.
// Two such bodies, skin and bone, and the brain space become Hounsfield units by soft steps as wide
// as the point spread of a scanner. Everything but the bead on the left ear is evaluated at |x|, so
// every shape off the mid-plane stands for two. Proportions: head 215 mm high, 188 long, 150 wide,
// eyes half way up, pupils 62 mm apart, nose 34 wide, mouth 50.

namespace isolux {
namespace {

struct Ellipsoid {
  Vec3 center;
  Vec3 radii;
};

struct Ball {
  Vec3 center;
  double radius;
};

/// The hull of two balls, or nearly: the radius goes evenly from one end to the other.
struct Rod {
  Ball from;
  Ball to;
};

Ball bound(const Ellipsoid& e) { return {e.center, std::max({e.radii.x, e.radii.y, e.radii.z})}; }
Ball bound(const Rod& r) {
  const double half_length = length(r.to.center - r.from.center) / 2;
  return {(r.from.center + r.to.center) / 2, half_length + std::max(r.from.radius, r.to.radius)};
}

// First order: exact on the surface, off by curvature away from it, never below the ball's.
double distance(const Ellipsoid& e, Vec3 p) {
  const Vec3 q = p - e.center;
  const Vec3 unit{q.x / e.radii.x, q.y / e.radii.y, q.z / e.radii.z};
  const Vec3 slope{unit.x / e.radii.x, unit.y / e.radii.y, unit.z / e.radii.z};
  const double u = length(unit);
  return std::max(u * (u - 1) / std::max(length(slope), 1e-9), length(q) - bound(e).radius);
}

double distance(const Rod& r, Vec3 p) {
  const Vec3 axis = r.to.center - r.from.center;
  const Vec3 q = p - r.from.center;
  const double part = std::clamp(dot(q, axis) / dot(axis, axis), 0.0, 1.0);
  return length(q - part * axis) - (r.from.radius + part * (r.to.radius - r.from.radius));
}

// Polynomial smooth minimum: equals the minimum where a and b differ by `round_mm` or more.
double join(double a, double b, double round_mm) {
  const double h = std::max(round_mm - std::fabs(a - b), 0.0) / round_mm;
  return std::min(a, b) - h * h * round_mm / 4;
}
double common(double a, double b, double round_mm) { return -join(-a, -b, round_mm); }

/// The distance `d` from the point `p` to a body while it is being modelled. A shape too far off to
/// change `d` is passed over.
struct Clay {
  Vec3 p;
  double d;

  template <typename Shape>
  void add(const Shape& shape, double round_mm) {
    if (!beyond(bound(shape), d + round_mm)) d = join(d, distance(shape, p), round_mm);
  }
  template <typename Shape>
  void carve(const Shape& shape, double round_mm) {
    if (!beyond(bound(shape), round_mm - d)) d = common(d, -distance(shape, p), round_mm);
  }
  /// A row of rods from knot to knot.
  void add_row(double round_mm, std::initializer_list<Ball> knots) {
    for (auto to = knots.begin() + 1; to != knots.end(); ++to) add(Rod{to[-1], *to}, round_mm);
  }
  bool beyond(const Ball& ball, double mm) const {
    const Vec3 q = p - ball.center;
    const double reach = ball.radius + mm;
    return reach <= 0 || dot(q, q) >= reach * reach;
  }
};

double cranium_distance(Vec3 p) {
  Clay head{p, distance(Ellipsoid{{0, 18, 40}, {73, 82, 73}}, p)};
  head.add(Ellipsoid{{0, -28, 42}, {55, 56, 63}}, 24);  // forehead
  head.add(Ellipsoid{{0, 50, 22}, {56, 50, 46}}, 24);   // back of the head
  return head.d;
}

double skin_distance(Vec3 p, double cranium) {
  Clay c{p, cranium};
  c.add(Ellipsoid{{0, -38, -22}, {56, 47, 62}}, 24);          // face
  c.add(Rod{{{0, 24, -30}, 50}, {{0, 30, -150}, 53}}, 30);    // neck
  if (c.d > 45) return c.d;                                   // nothing below rises so far
  c.add(Ellipsoid{{30, -34, -46}, {22, 36, 28}}, 24);         // cheeks
  c.add(Rod{{{42, -14, -58}, 9}, {{11, -74, -83}, 13}}, 24);  // lower jaw
  c.add(Ellipsoid{{0, -82, -85}, {17, 13, 12}}, 14);          // chin
  c.add(Rod{{{44, -62, -12}, 13}, {{58, -16, -6}, 10}}, 26);  // cheek bones
  c.add(Ellipsoid{{45, -38, 12}, {15, 28, 24}}, 18);          // temples
  c.add_row(18, {{{8, -82, 23}, 5}, {{30, -77, 27}, 5}, {{48, -63, 19}, 5}});  // brows
  c.carve(Ellipsoid{{32, -97, 5}, {19, 19, 11}}, 12);                          // eye hollows
  c.add(Ellipsoid{{32, -70, 5}, {16, 14.5, 12.5}}, 4);                         // eyes
  c.carve(Rod{{{18, -80.5, 2}, 1}, {{32, -85.5, -1.5}, 1.3}}, 2);              // between the lids
  c.carve(Rod{{{32, -85.5, -1.5}, 1.3}, {{46, -78, 2}, 1}}, 2);
  c.add(Rod{{{0, -82, 18}, 7}, {{0, -100, -24}, 8}}, 10);      // bridge of the nose
  c.add(Rod{{{0, -78, 10}, 7}, {{0, -88, -25}, 12}}, 8);       // its sides
  c.add(Ellipsoid{{0, -102, -28}, {9.5, 10, 8.5}}, 6);         // its tip
  c.add(Ellipsoid{{11.5, -94, -30}, {6, 9, 7.5}}, 6);          // its wings
  c.carve(Ellipsoid{{6.5, -99, -38}, {3.2, 6, 4}}, 3);         // nostrils
  c.add(Ellipsoid{{0, -74, -56}, {30, 17, 19}}, 14);           // round the mouth
  c.add(Ellipsoid{{0, -82, -52.5}, {24, 14.5, 6.5}}, 4);       // upper lip
  c.add(Ellipsoid{{0, -82, -62.5}, {21, 14, 7}}, 3);           // lower lip
  c.carve(Rod{{{0, -98, -57}, 1}, {{25, -84, -58}, 1}}, 2.5);  // between the lips
  c.carve(Rod{{{0, -98, -40}, 2}, {{0, -99, -46}, 2}}, 5);     // groove above them
  c.add(Rod{{{54, 24, -24}, 8}, {{12, -24, -130}, 8}}, 24);    // neck muscles
  Clay ear{{p.x - 0.4 * (p.y - 10), p.y, p.z}, 1e3};           // sheared: the rim stands off behind
  ear.add(Ellipsoid{{70, 22, -2}, {6, 17, 30}}, 1);
  ear.carve(Ellipsoid{{78, 21, 2}, {6.5, 11.5, 22}}, 3);
  ear.add(Rod{{{71, 25, -10}, 2.5}, {{71, 23, 14}, 3}}, 4);  // inner rim
  ear.carve(Ellipsoid{{75, 14, -7}, {6, 6.5, 9}}, 3);
  ear.add(Rod{{{66, 5, -12}, 4.5}, {{71, 5, -7}, 3.5}}, 3);
  ear.add(Ellipsoid{{60, 16, -4}, {11, 10, 16}}, 6);  // its root
  c.d = join(c.d, ear.d, 6);
  return common(c.d, -121 - p.z, 6);  // the neck ends
}

double share(double distance_mm, double blur_mm) {
  const double x = std::clamp((blur_mm - distance_mm) / (2 * blur_mm), 0.0, 1.0);
  return x * x * (3 - 2 * x);
}
double toward(double from, double to, double part) { return from + part * (to - from); }

// Grooves where the plates of the skull meet: along the mid-plane, and from temple to temple.
double suture_mm(Vec3 p) {
  const double sagittal = p.x - 2 - 0.3 * exact::sin(p.y * 0.9) - 0.3 * exact::sin(p.y * 2.1);
  const double wave = 1.8 * exact::sin(p.x * 0.6) + 0.9 * exact::sin(p.x * 1.5);
  const double coronal = std::fabs(p.y + 24 + 0.2 * p.x - wave) - 0.6;
  const double ends = share(34 - p.z, 14);
  const double sagittal_ends = share(-20 - p.y, 3) * share(70 - p.z, 8);
  return 1.8 * std::max(share(sagittal, 1.4) * sagittal_ends, share(coronal, 1.4) * ends);
}

const std::initializer_list<Ball> kEyeRim = {
    {{8, -79, 24}, 4},     {{30, -76, 27.5}, 4}, {{46, -66, 20}, 4}, {{50, -62, 5}, 4},
    {{49, -62, -13}, 4.5}, {{21, -75, -18}, 4},  {{7, -80, 18}, 4}};

struct Tooth {
  double x, y, radius;  // mm
};
// The upper row, front to back; the lower one follows it.
constexpr Tooth kTeeth[] = {{4, -84.5, 3.5},  {11.4, -82, 3.1}, {17.8, -77.5, 3.3},
                            {22.2, -71, 3.3}, {25.2, -64, 3.3}, {27.6, -55.5, 4.2},
                            {29.2, -46, 4.2}};

double bone_distance(Vec3 p, double brain_space) {
  Clay c{p, brain_space - 7};
  if (p.z > 20) c.d += suture_mm(p);
  c.add(Ellipsoid{{0, -52, -20}, {33, 32, 26}}, 8);  // upper jaw
  c.add_row(6, {{{0, -79, -42}, 6.5}, {{15, -75, -42}, 6.5}, {{27, -42, -42}, 6.5}});
  c.add(Ellipsoid{{30, -54, 4}, {23, 22, 24}}, 8);   // round the eyes
  c.add(Ellipsoid{{0, -60, 4}, {11, 24, 22}}, 8);    // between them
  c.add(Ellipsoid{{44, -61, -17}, {12, 8, 8}}, 12);  // cheek bones
  c.add_row(8,
            {{{50, -58, -14}, 5}, {{63.5, -28, -9}, 4}, {{57, 4, -6}, 5.5}});  // and their arches
  c.carve(Rod{{{32, -94, 4}, 21}, {{18, -46, 3}, 9}}, 4);                      // eye sockets
  c.add_row(7, kEyeRim);
  c.add(Rod{{{0, -78, 18}, 6}, {{0, -90, -4}, 4.5}}, 6);      // nasal bones
  c.carve(Rod{{{0, -100, -27}, 11}, {{0, -14, -26}, 9}}, 3);  // nasal opening
  c.carve(Ellipsoid{{0, -86, -16}, {6.5, 30, 10}}, 4);
  c.carve(Ellipsoid{{0, -54, -54}, {19, 24, 13}}, 4);      // palate
  c.add(Rod{{{56, 20, -14}, 10}, {{53, 20, -34}, 7}}, 8);  // behind the ear
  c.d = join(c.d, brain_space - 3.5, 2);
  Clay jaw{p, 1e3};
  jaw.add_row(1, {{{0, -78, -86}, 9.5}, {{20, -72, -86}, 9}, {{45, -20, -74}, 7}});  // lower jaw
  jaw.add_row(8, {{{0, -77, -76}, 6.5}, {{14, -73, -76}, 6.5}, {{34, -36, -72}, 8}});
  jaw.add(Ellipsoid{{48, -14, -52}, {6, 20, 30}}, 8);
  jaw.add(Rod{{{50, -6, -40}, 6}, {{52, 0, -16}, 5}}, 6);
  jaw.add(Rod{{{48, -24, -40}, 5}, {{48, -28, -22}, 3.5}}, 6);
  c.d = join(c.d, jaw.d, 2);
  for (const auto& [x, y, radius] : kTeeth) {
    if (c.beyond({{0, -65, -59}, 48}, c.d + 2)) break;  // far from all of them
    const double low_x = 0.93 * x, low_y = y + 2.5, low_radius = 0.93 * radius;
    c.add(Rod{{{x, y, -44}, radius}, {{x, y, -58.5 + radius}, radius}}, 0.8);
    c.add(Rod{{{low_x, low_y, -74}, low_radius}, {{low_x, low_y, -61 - radius}, low_radius}}, 0.8);
  }
  c.add(Rod{{{14, 18, -20}, 7}, {{14, 16, -40}, 6}}, 5);  // spine
  c.add(Rod{{{0, 16, -18}, 6}, {{0, 16, -40}, 6}}, 5);
  for (double z = -44; z > -115; z -= 16.5) {
    const double y = 14 + 0.004 * (z + 80) * (z + 80);
    if (c.beyond({{0, y + 15, z - 3}, 36}, c.d + 4)) continue;
    c.add(Ellipsoid{{0, y, z}, {14, 11, 8.5}}, 3);
    c.add(Rod{{{8, y + 2, z}, 4}, {{25, y + 5, z - 1}, 4}}, 4);
    c.add(Rod{{{16, y + 6, z}, 4}, {{4, y + 26, z - 3}, 4}}, 4);
    c.add(Rod{{{0, y + 26, z - 3}, 4}, {{0, y + 40, z - 8}, 4}}, 4);
  }
  c.d = common(c.d, -brain_space, 2);
  c.carve(Rod{{{0, 32, 0}, 12}, {{0, 32, -40}, 12}}, 3);  // way of the spinal cord
  return c.d;
}

double hounsfield(Vec3 world, double blur_mm) {
  constexpr double kAir = -1000, kTissue = 40, kBrain = 35, kFluid = 5;
  constexpr double kSpongy = 750, kDense = 1150, kBead = 1500;
  // The mark: a bead of 9 mm radius on the left ear only.
  const double bead_share = share(length(world - Vec3{84, 15, -28}) - 9, blur_mm);
  // |x|, rounded by 1.5 mm so that nothing creases at the mid-plane.
  const Vec3 p{std::sqrt(world.x * world.x + 2.25), world.y, world.z};
  const double cranium = cranium_distance(p);
  const double skin = skin_distance(p, cranium);
  if (skin >= blur_mm) return toward(kAir, kBead, bead_share);
  // The brain rests on a base that slopes down from the brows to the neck.
  const double base = 0.905 * (-5 - 0.47 * p.y - p.z);
  const double brain_space = common(cranium + 13, base, 16);
  double hu = toward(kAir, kTissue, share(skin, blur_mm));
  if (brain_space < blur_mm) {
    const double folds = exact::sin(0.35 * p.x) * exact::sin(0.3 * p.y) * exact::sin(0.38 * p.z);
    hu = toward(hu, kFluid, share(brain_space, blur_mm));
    hu = toward(hu, kBrain + 8 * folds, share(brain_space + 3, blur_mm));
  }
  if (brain_space > -2 - blur_mm && skin < -1.4) {
    // Never through the skin, however blurred.
    const double bone = common(bone_distance(p, brain_space), skin + 1.4 + blur_mm, 2);
    // Dense outside, spongy 3 mm deep.
    const double inside = toward(kDense, kSpongy, share(bone + 3.5, blur_mm));
    hu = toward(hu, inside, share(bone, blur_mm));
    Clay air{p, 1e3};  // nose, throat, windpipe
    air.add_row(3, {{{0, -78, -27}, 7}, {{0, -24, -29}, 7}, {{0, -9, -108}, 6}});
    hu = toward(hu, kAir, share(common(air.d, 2 - bone, 2), blur_mm));
  }
  return toward(hu, kBead, bead_share);
}

}  // namespace

Volume head_phantom(int size) {
  constexpr double kHalf = 127.5;  // mm
  // Coarse voxels see a wider point spread, or surfaces would show steps.
  const double blur_mm = std::max(1.6, 1.2 * 2 * kHalf / (size - 1));
  Volume volume = sample_on_cube<std::int16_t>(
      size, kHalf, [blur_mm](Vec3 p_mm) { return hounsfield(p_mm, blur_mm); });
  volume.modality = "CT";
  volume.units = "HU";
  return volume;
}

}  // namespace isolux
