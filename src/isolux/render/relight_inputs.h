#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "isolux/image/display_table.h"
#include "isolux/image/picture.h"
#include "isolux/render/indirect.h"
#include "isolux/render/lighting.h"
#include "isolux/render/shadows.h"
#include "isolux/render/surface_buffer.h"
#include "isolux/scene/scene.h"

// What relight.cpp says to the code for each instruction set (relight_lanes.cpp): plain floats,
// positions relative to the eye.

namespace isolux::relighting {

struct Inputs {
  struct Surface {
    float ambient[3];  ///< opacity * ka * Ia
    float kd[3];       ///< times the opacity, as ks
    float ks[3];
    float shininess;
  };
  struct Lamp {
    bool is_point;
    float place[3];  ///< or the unit vector to it
    float intensity[3];
    float reference_square;  ///< of the falloff's reference distance; 0: no falloff
  };

  Inputs(const Scene& scene, const SurfaceBuffer& buffer, const Shadows& shadows,
         const Indirect& indirect);

  const Scene* scene;
  const SurfaceBuffer* buffer;
  const Shadows* shadows;
  const Indirect* indirect;
  std::vector<Surface> surfaces;
  std::vector<Lamp> lamps;
  bool has_painted = false;
  Vec3 eye;
  float background[3];
  bool is_orthographic;
  float origin[3][3];  ///< of the eye rays: first, along x, along y (see RayFan)
  float direction[3][3];
  const DisplayTable* table = nullptr;  ///< needed where there is a picture
  std::uint32_t background_bytes = 0;   ///< r | g << 8 | b << 16
};

/// Where results go; what is null is not wanted. All terms or none.
struct Outputs {
  RgbLayer* total = nullptr;
  RgbLayer* ambient = nullptr;  ///< or indirect light, which takes its place
  RgbLayer* diffuse = nullptr;
  RgbLayer* specular = nullptr;
  RgbLayer* mirror = nullptr;
  Picture* picture = nullptr;
  /// Which pixels of the picture may show something else than the background as it is now, as
  /// SurfaceBuffer::hits; blocks without any of these and without hits are left alone.
  const std::vector<std::uint64_t>* drawn = nullptr;
};

/// Lights the tiles [begin, end), and draws them if there is a picture.
void light(const Inputs& in, std::size_t begin, std::size_t end, const Outputs& out);
/// Draws them from the total.
void show(const Inputs& in, std::size_t begin, std::size_t end, const Outputs& out);

/// Lights, pixel by pixel in doubles, those that show a painted mesh.
void light_painted(const Inputs& in, std::size_t begin, std::size_t end, const Outputs& out);

/// Adds the terms of a further point, in its own weight, and the background where it is that, to
/// its pixel.
void add_further(const Inputs& in, std::size_t tile, const FurtherPoint& point,
                 const float (&ambient)[3], const float (&diffuse)[3], const float (&specular)[3],
                 const Outputs& out);
/// The same point lit in doubles first.
void add_further_plainly(const Inputs& in, std::size_t tile, std::size_t point, const Outputs& out);

/// The further points of tiles [begin, end), added to what `light` made of the nearest.
void light_further_plainly(const Inputs& in, std::size_t begin, std::size_t end,
                           const Outputs& out);

/// The same pixel by pixel in doubles: the oracle, and what machines without SSE4 use.
void light_plainly(const Inputs& in, std::size_t begin, std::size_t end, const Outputs& out);
void show_plainly(const Inputs& in, std::size_t begin, std::size_t end, const Outputs& out);

/// Copies 4 x 4 pixels (as background_bytes) into the picture, as far as they lie in it.
void write_block(const std::uint32_t* pixels, Picture& picture, int x0, int y0);

}  // namespace isolux::relighting
