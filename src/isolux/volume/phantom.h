#pragma once

#include <optional>

#include "isolux/volume/volume.h"

namespace isolux {

/// f(p) = 1 - |p| / 32 mm on a cube from -32 to 32 mm about the world origin, float32; 65 voxels a
/// side unless `size` says otherwise. The iso value 0.5 is the sphere of radius 16 mm.
Volume sphere_phantom(int size = 65);

/// The test signal of Marschner and Lobb 1994, "An evaluation of reconstruction filters for volume
/// rendering", on [-1, 1]^3, float32, 41 voxels a side unless `size` says otherwise:
///   f(x, y, z) = (1 - sin(pi z / 2) + alpha (1 + rho(sqrt(x^2 + y^2)))) / (2 (1 + alpha)),
///   rho(r) = cos(2 pi f_M cos(pi r / 2)),  f_M = 6, alpha = 0.25.
Volume marschner_lobb_phantom(int size = 41);

/// A head in Hounsfield units, int16, on a cube from -127.5 to 127.5 mm about the world origin in
/// LPS, 256 voxels a side unless `size` says otherwise; see head_phantom.cpp for its formula. It
/// faces anterior (-y), and its left ear (+x) is marked with a bead of bone.
Volume head_phantom(int size = 256);

}  // namespace isolux
