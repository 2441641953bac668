#include "isolux/volume/phantom.h"

#include <cmath>

#include "isolux/base/exact_math.h"
#include "isolux/volume/analytic_volume.h"

namespace isolux {

Volume sphere_phantom(int size) {
  return sample_on_cube<float>(size, 32, [](Vec3 p_mm) { return 1 - length(p_mm) / 32; });
}

Volume marschner_lobb_phantom(int size) {
  constexpr double kFrequency = 6;
  constexpr double kAlpha = 0.25;
  return sample_on_cube<float>(size, 1, [](Vec3 p) {
    const double r = std::sqrt(p.x * p.x + p.y * p.y);
    const double rho = exact::cos(2 * exact::kPi * kFrequency * exact::cos(exact::kPi * r / 2));
    return (1 - exact::sin(exact::kPi * p.z / 2) + kAlpha * (1 + rho)) / (2 * (1 + kAlpha));
  });
}

}  // namespace isolux
