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

/// A camera in world space. Row 0 is the top of the picture; rays pass through pixel centres.
class Camera {
 public:
  /// @throws UsageError  where eye and target are the same place, or up points along the view.
  Camera(const CameraDescription& description, int width, int height,
         const BoundingSphere& everything);

  /// The eye ray of pixel (x, y), counted from 0 at the top left: a unit direction, so that t is
  /// the distance in mm from the eye (orthographic: from the eye's plane).
  Ray ray(int x, int y) const;

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
};

}  // namespace isolux
