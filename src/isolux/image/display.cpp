#include "isolux/image/display.h"

#include <algorithm>
#include <cmath>

#include "isolux/base/exact_math.h"

namespace isolux {

double transfer(const Display& display, double value) {
  if (display.curve == Display::Curve::kRaw) return value;
  return value <= 0.0031308 ? 12.92 * value : 1.055 * exact::pow(value, 1 / 2.4) - 0.055;
}

double linear_from_srgb(double coded) {
  return coded <= 0.04045 ? coded / 12.92 : exact::pow((coded + 0.055) / 1.055, 2.4);
}

std::array<std::uint8_t, 3> displayed(const Display& display, Rgb radiance) {
  std::array<std::uint8_t, 3> pixel{};
  for (int channel = 0; channel < 3; ++channel) {
    const double shown = transfer(display, display.exposure * radiance[channel]);
    pixel[static_cast<std::size_t>(channel)] =
        static_cast<std::uint8_t>(std::floor(255 * std::clamp(shown, 0.0, 1.0) + 0.5));
  }
  return pixel;
}

}  // namespace isolux
