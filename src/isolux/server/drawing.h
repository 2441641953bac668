#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "isolux/base/progress.h"
#include "isolux/render/seen.h"
#include "isolux/render/session.h"
#include "isolux/scene/scene.h"
#include "isolux/server/messages.h"

namespace isolux {

/// Draws the frames of one page: soon while something moves, and the very picture of
/// `isolux render` when it has come to rest. One thread at a time.
class Drawing {
 public:
  /// A frame as it goes over the wire: the length of a JSON header in four bytes (least significant
  /// first), the header, and one or two picture files, whose lengths the header tells.
  ///
  /// What does not fit the time of a moving frame is drawn with fewer pixels: rays, where the eye
  /// moves or paths are followed; only sent with fewer, where the line is slow.
  /// @param description  of the scene that `request` carries, with `inputs` for its inputs.
  /// @param bytes_per_ms  what the line to the page has carried lately; 0: not known.
  /// @param listener  is told of the tracing, and may throw to end it.
  std::string frame(const ViewRequest& request, const SceneDescription& description,
                    const std::vector<SceneInput>& inputs, double bytes_per_ms,
                    const ProgressListener& listener);

  /// What the last frame shows there, in shares of width and height: nothing where no surface was
  /// met, or nothing was drawn yet.
  struct Picked {
    Vec3 position;
    Vec3 normal;
    double depth_mm;
  };
  std::optional<Picked> pick(double across, double down);

 private:
  int reduction_for(const Scene& whole, bool settled) const;

  Session session_;
  std::optional<Scene> scene_;        ///< as the last frame drew it
  std::optional<Scene> whole_;        ///< the same with all its pixels
  std::optional<PicturePart> seen_;   ///< where surfaces were met
  int reduction_ = 1;                 ///< how many pixels along each side became one
  double trace_ms_per_pixel_ = 3e-4;  ///< a first guess, so that the first frame comes soon
  double shadow_ms_per_pixel_ = 0;    ///< with the lighting
  double path_ms_per_pixel_ = 1e-4;   ///< one path each, denoised; a guess as well
  double sent_bytes_per_pixel_ = 0;
};

}  // namespace isolux
