#pragma once

#include <embree3/rtcore.h>

#include "isolux/bench/mesh_file.h"
#include "isolux/bench/ppm.h"

using Mesh = isolux::PeerMesh;

struct Vec3f {
  float x, y, z;
};

/// A perspective camera: unit axes, and half the picture's height at 1 mm from the eye.
struct PeerCamera {
  Vec3f eye, right, up, forward;
  float half_height;
};

struct Lamp {
  bool is_point;
  Vec3f place;  ///< position, or the unit vector towards it
};

/// Draws a mesh as isolux draws an isosurface: white, ka .1, kd .8, ks .3, shininess 40, sRGB; rays
/// go in packets of 4x4 pixels. How many pixels are hit. The picture's sides must be multiples
/// of 4.
std::size_t draw_frame(RTCScene scene, const Mesh& mesh, const PeerCamera& camera, const Lamp& lamp,
                       isolux::Ppm& picture);
