#include "isolux/scene/camera.h"

#include <algorithm>
#include <cmath>
#include <map>

#include "isolux/base/error.h"
#include "isolux/base/exact_math.h"

namespace isolux {
namespace {

// LPS: +x is the patient's left, +y posterior, +z superior.
struct NamedView {
  Vec3 back;  // from the target towards the eye
  Vec3 up;
};

const std::map<std::string, NamedView>& named_views() {
  static const std::map<std::string, NamedView> views = {
      {"front", {{0, -1, 0}, {0, 0, 1}}}, {"back", {{0, 1, 0}, {0, 0, 1}}},
      {"left", {{1, 0, 0}, {0, 0, 1}}},   {"right", {{-1, 0, 0}, {0, 0, 1}}},
      {"top", {{0, 0, 1}, {0, -1, 0}}},   {"bottom", {{0, 0, -1}, {0, -1, 0}}},
  };
  return views;
}

}  // namespace

Camera::Camera(const CameraDescription& description, int width, int height,
               const BoundingSphere& everything)
    : width_(width), height_(height), orthographic_(description.orthographic) {
  const double radius = everything.radius_mm;
  const double aspect = static_cast<double>(width) / height;
  half_height_ = orthographic_
                     ? description.height_mm.value_or(2 * radius / std::min(1.0, aspect)) / 2
                     : exact::tan(exact::radians(description.fov_deg) / 2);
  Vec3 up{0, 0, 1};
  if (description.view) {
    const NamedView& view = named_views().at(*description.view);
    // The sphere touches the narrower pair of the picture's edges: sin(half angle) = radius / d.
    const double half_tangent = half_height_ * std::min(1.0, aspect);
    const double distance =
        orthographic_ ? 2 * radius
                      : radius * std::sqrt(1 + half_tangent * half_tangent) / half_tangent;
    eye_ = everything.center + distance * view.back;
    back_ = view.back;
    up = view.up;
  } else {
    eye_ = *description.eye;
    up = description.up.value_or(up);
    const Vec3 from_target = eye_ - description.target.value_or(everything.center);
    if (from_target == Vec3{}) {
      throw UsageError("--camera", "eye and target are the same place", "move one of them");
    }
    back_ = normalize(from_target);
  }
  if (up == Vec3{} || !(length(cross(normalize(up), back_)) > 1e-9)) {
    throw UsageError("--camera", "up points along the view", "give another up=X:Y:Z");
  }
  right_ = normalize(cross(up, back_));
  up_ = cross(back_, right_);

  const double pixel = pixel_size();
  const RayFan::Plane across{
      (0.5 - 0.5 * width_) * pixel * right_ + (0.5 * height_ - 0.5) * pixel * up_, pixel * right_,
      -pixel * up_};
  fan_ = orthographic_
             ? RayFan{{eye_ + across.first, across.along_x, across.along_y}, {-back_, {}, {}}}
             : RayFan{{eye_, {}, {}}, {across.first - back_, across.along_x, across.along_y}};
}

Ray Camera::ray(int x, int y) const {
  const Ray ray = fan_.ray(x, y);
  return {ray.origin, normalize(ray.direction)};
}

RayFan carried(const Affine& map, const RayFan& fan) {
  const auto& [origin, direction] = fan;
  return {
      {map.point(origin.first), map.vector(origin.along_x), map.vector(origin.along_y)},
      {map.vector(direction.first), map.vector(direction.along_x), map.vector(direction.along_y)}};
}

}  // namespace isolux
