#pragma once

#include <memory>
#include <optional>

#include "isolux/bench/framing.h"
#include "isolux/image/picture.h"
#include "isolux/render/indirect.h"
#include "isolux/render/ray_caster.h"
#include "isolux/render/relight.h"
#include "isolux/render/surface_buffer.h"
#include "isolux/scene/scene.h"

namespace isolux {

/// The steps of a frame as isolux does them, each a call of its own so that it can be timed. No
/// answer is kept from one frame to the next.
class OwnRenderer {
 public:
  explicit OwnRenderer(Scene scene);

  const Scene& scene() const { return scene_; }

  // Changes. They take no time; what follows from them is done by the steps below.
  void look(const View& view);
  void set_shadows(bool on) { scene_.shadows = on; }
  void set_iso(double iso) { scene_.surfaces[0].iso = iso; }
  void set_visibility(Visibility visibility) { scene_.visibility = visibility; }
  /// The first light becomes a point light of intensity 1 at `at`; nothing: a headlight.
  void set_lamp(std::optional<Vec3> at);
  /// Shadows, and indirect light by so many paths a pixel.
  void set_paths(int spp, int bounces);

  // Steps, in their order.
  /// What the iso value needs; the min-max bricks of the volume are made at the first call alone.
  void prepare();
  void trace();
  /// Shadows and paths, if they are on; lighting and display, which go in one pass.
  void relight();
  /// Display alone, of what has been lit.
  void redisplay();
  /// What a new view needs: trace and relight.
  void frame();

  const SurfaceBuffer& surfaces() const { return *buffer_; }
  const Picture& picture() const { return picture_.picture(); }
  std::size_t hit_pixels() const;

 private:
  Indirect followed_paths() const;

  Scene scene_;
  std::optional<RayCaster> caster_;
  std::optional<SurfaceBuffer> buffer_;
  Shadows shadows_;
  LitPicture picture_;
};

/// Isosurface `iso` of a volume in white under a headlight, seen from its orbit.
Scene bench_scene(const std::shared_ptr<const Volume>& volume, double iso, int width, int height);
/// The same of a mesh.
Scene bench_scene(const std::shared_ptr<const Mesh>& mesh, int width, int height);

/// From the lowest corner of a surface's box to its highest, in mm.
Vec3 box_size(const SurfaceItem& surface);

}  // namespace isolux
