#pragma once

#include <functional>
#include <memory>
#include <optional>

#include "isolux/base/progress.h"
#include "isolux/image/picture.h"
#include "isolux/render/indirect_light.h"
#include "isolux/render/ray_caster.h"
#include "isolux/render/relight.h"
#include "isolux/render/shadows.h"
#include "isolux/render/surface_buffer.h"
#include "isolux/scene/scene.h"

namespace isolux {

/// Draws one scene after another and reruns only what the change between them touches:
///
/// | changed                                | rerun                                          |
/// |----------------------------------------|------------------------------------------------|
/// | exposure, curve                        | display                                        |
/// | materials, lights, ambient, background | lighting, display                              |
/// | where lights are, if there are shadows | shadows, lighting, display                     |
/// | any of these but the last two, with indirect light | that as well                       |
/// | camera, size, opacity, kr              | visibility, shadows, lighting, display         |
/// | iso values, surfaces                   | skip structure, visibility, lighting, display  |
/// | volumes                                | min-max bricks and all of the above            |
///
/// Volumes are told apart by where they live, not by their values. One thread at a time may call;
/// what is returned stays valid until the next call.
class Session {
 public:
  /// How often each stage has run.
  struct Counters {
    int skip_structure = 0;
    int visibility = 0;
    int shadows = 0;
    int indirect = 0;
    int lighting = 0;
    int display = 0;

    bool operator==(const Counters&) const = default;
  };

  const SurfaceBuffer& surfaces(const Scene& scene, const ProgressListener& listener = {});
  /// Empty where the scene asks for none.
  const Shadows& shadows(const Scene& scene);
  /// Empty where the scene asks for none.
  /// With `stop` it may be unfinished (see IndirectLight), and what is lit with it as well; the
  /// next call goes on from there.
  const Indirect& indirect(const Scene& scene, const ProgressListener& listener = {},
                           const std::function<bool()>& stop = {});
  /// The terms kept apart, which `picture` does without.
  const Radiance& radiance(const Scene& scene);
  const Picture& picture(const Scene& scene);
  /// The picture of what lamps send straight to what is seen: without ambient and indirect light,
  /// in mirrors as well.
  const Picture& direct_picture(const Scene& scene);

  const Counters& counters() const { return counters_; }

 private:
  // A picture with the scene that it shows.
  struct Drawn {
    std::optional<Scene> scene;
    LitPicture picture;
  };

  void trace(const Scene& scene, const ProgressListener& listener);
  const Picture& draw(const Scene& scene, Drawn& drawn);
  const Indirect& indirect_as_found(const Scene& scene);

  Counters counters_;
  // Each stage with the scene that it last ran for.
  std::optional<Scene> prepared_, traced_, shadowed_, bounced_, lit_;
  std::optional<RayCaster> caster_;
  std::optional<SurfaceBuffer> buffer_;
  Shadows shadows_;
  IndirectLight indirect_light_;
  std::optional<Radiance> radiance_;
  Drawn drawn_, drawn_direct_;
};

}  // namespace isolux
