#include "isolux/bench/framing.h"

#include "isolux/base/exact_math.h"

namespace isolux {
namespace {

Vec3 turned_about_z(Vec3 v, double deg) {
  const double c = exact::cos(exact::radians(deg)), s = exact::sin(exact::radians(deg));
  return {c * v.x - s * v.y, s * v.x + c * v.y, v.z};
}

View outside_view(Vec3 box_mm, double turn_deg, double nearness) {
  constexpr double kFov = 30;
  const double radius = length(box_mm) / 2;
  const double distance = radius / exact::sin(exact::radians(kFov / 2)) / nearness;
  const Vec3 center = box_mm / 2;
  return {center + distance * turned_about_z(normalize({0, -1, 0.2}), turn_deg), center, kFov};
}

}  // namespace

View orbit_view(Vec3 box_mm, double turn_deg) { return outside_view(box_mm, turn_deg, 1); }

View close_view(Vec3 box_mm, double turn_deg) { return outside_view(box_mm, turn_deg, 2.2); }

View inside_view(Vec3 box_mm, double turn_deg) {
  const Vec3 eye{0.5 * box_mm.x, 0.5 * box_mm.y, 0.7 * box_mm.z};
  return {eye, eye + turned_about_z({0, -1, 0}, turn_deg), 90};
}

}  // namespace isolux
