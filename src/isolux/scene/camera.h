#pragma once

#include "isolux/base/affine.h"
#include "isolux/base/ray.h"
#include "isolux/scene/description.h"

namespace isolux {

/// The smallest thing that named views fit: a sphere around the boxes of all inputs.
struct BoundingSphere {
  Vec3 center;
  double radius_mm = 0;
};

/// The eye rays of a picture as functions of the pixel: origin and direction of pixel (x, y) are
/// each first + x * along_x + y * along_y. Directions have length 1 along the line of sight, so t
/// counts the distance in mm from the eye's plane.
struct RayFan {
  struct Plane {
    Vec3 first, along_x, along_y;

    Vec3 at(double x, double y) const { return first + x * along_x + y * along_y; }
    bool operator==(const Plane&) const = default;
  };

  Plane origin, direction;

  Ray ray(double x, double y) const { return {origin.at(x, y), direction.at(x, y)}; }
  bool operator==(const RayFan&) const = default;
};

/// The same rays in another space.
RayFan carried(const Affine& map, const RayFan& fan);

/// A camera in world space. Row 0 is the top of the picture; rays pass through pixel centres.
class Camera {
 public:
  /// @throws UsageError  where eye and target are the same place, or up points along the view.
  Camera(const CameraDescription& description, int width, int height,
         const BoundingSphere& everything);

  /// The eye ray of pixel (x, y), counted from 0 at the top left: a unit direction, so that t is
  /// the distance in mm from the eye (orthographic: from the eye's plane).
  Ray ray(int x, int y) const;

  /// All of them, not of unit length.
  const RayFan& fan() const { return fan_; }

  Vec3 eye() const { return eye_; }
  bool is_orthographic() const { return orthographic_; }
  /// A pixel's edge in mm; for a perspective camera at 1 mm from the eye.
  double pixel_size() const { return 2 * half_height_ / height_; }
  int width() const { return width_; }
  int height() const { return height_; }
  bool orthographic() const { return orthographic_; }
  /// Half the picture's height: in mm, or for a perspective camera at 1 mm from the eye.
  double half_height() const { return half_height_; }

  /// Camera space (x right, y up, z towards the viewer, origin at the eye) into world space.
  Affine world_from_camera() const { return {{{right_, up_, back_}}, eye_}; }

  bool operator==(const Camera&) const = default;

 private:
  int width_;
  int height_;
  bool orthographic_;
  Vec3 eye_, right_, up_, back_;
  double half_height_;
  RayFan fan_;
};

}  // namespace isolux
