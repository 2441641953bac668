#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "isolux/image/display_table.h"
#include "isolux/image/picture.h"
#include "isolux/render/indirect.h"
#include "isolux/render/lighting.h"
#include "isolux/render/shadows.h"
#include "isolux/render/surface_buffer.h"
#include "isolux/scene/scene.h"

namespace isolux {

namespace relighting {
struct Inputs;
struct Outputs;
}  // namespace relighting

/// Lights every pixel, in lanes of floats, on all threads: the terms of `light_point`, its plain
/// oracle, within 2e-6 (3 + sqrt(shininess)) of the sum of the intensities. `shadows`
/// and `indirect`: those of the buffer, if the scene asks for any.
Radiance light(const Scene& scene, const SurfaceBuffer& buffer, const Shadows& shadows = {},
               const Indirect& indirect = {});

/// A picture that is drawn again and again. Only what can have changed is written: a lamp that
/// moves costs nothing where no surface is.
class LitPicture {
 public:
  /// Lights `buffer` and draws it.
  const Picture& relight(const Scene& scene, const SurfaceBuffer& buffer,
                         const Shadows& shadows = {}, const Indirect& indirect = {});
  /// Draws it again, with another display alone. `relight` must have gone before.
  const Picture& redisplay(const Scene& scene, const SurfaceBuffer& buffer);

  const Picture& picture() const { return picture_; }

 private:
  using Stage = void (*)(const relighting::Inputs&, std::size_t begin, std::size_t end,
                         const relighting::Outputs&);

  const Picture& draw(const Scene& scene, const SurfaceBuffer& buffer, const Shadows& shadows,
                      const Indirect& indirect, Stage stage);
  void prepare(const Scene& scene, const SurfaceBuffer& buffer);

  std::optional<DisplayTable> table_;
  std::optional<RgbLayer> total_;
  Picture picture_;
  std::uint32_t background_ = 0;
  std::vector<std::uint64_t> drawn_;  ///< as SurfaceBuffer::hits, for the picture as it is
};

}  // namespace isolux
