#pragma once

#include <memory>
#include <vector>

#include "isolux/render/lighting.h"
#include "isolux/render/surface_buffer.h"
#include "isolux/scene/camera.h"

namespace isolux {

/// Takes the noise out of light that was found by few samples a pixel.
///
/// The light is taken apart into details of 1, 2, ... 16 pixels by a wavelet that heeds edges
/// (Dammertz, Sewtz, Hanika, Lensch 2010, "Edge-avoiding A-Trous wavelet transform for fast global
/// illumination filtering"): pixels are smoothed into each other where they show the same surface,
/// their normals differ by less than 60 degrees, and they lie near each other's tangent plane. Of
/// each detail that share is taken away which the variance of the pixels explains (Starck, Murtagh
/// 1994), where Dammertz and Schied 2017 (SVGF) stop at differences in brightness instead: so what
/// is too bright by chance does not count for less than what is too dark, and nothing changes where
/// there is no variance. Constant light stays as it is, but for rounding.
///
/// Keeps its memory from call to call.
class Denoiser {
 public:
  Denoiser();
  ~Denoiser();

  /// Changes `light` where the buffer shows a surface. `variance`: of the mean over the channels,
  /// or too large; empty: not known, and told from the finest detail, which is then lost. Both
  /// [place in the buffer]. All threads.
  void denoise(const Camera& camera, const SurfaceBuffer& buffer,
               const std::vector<float>& variance, RgbLayer& light);

  /// Bytes for each pixel.
  static constexpr double kBytesPerPixel = 80;

 private:
  struct Planes;
  std::unique_ptr<Planes> planes_;
};

}  // namespace isolux
