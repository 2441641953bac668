#pragma once

#include <functional>
#include <optional>
#include <string>

#include "isolux/base/progress.h"
#include "isolux/render/denoise.h"
#include "isolux/render/indirect.h"
#include "isolux/render/scene_surfaces.h"
#include "isolux/render/surface_buffer.h"
#include "isolux/render/transport.h"
#include "isolux/scene/scene.h"

namespace isolux {

/// Indirect light by the method that a scene asks for. Keeps cached transport, which outlives
/// lamps, colours and cameras, as long as the surfaces stay.
class IndirectLight {
 public:
  /// Empty where the scene asks for none. `stop` is asked now and then while transport is missing
  /// links: whether to make do with those there are; none: never. With it, a buffer that has
  /// changed is lit by a sketch. Listeners may throw, to cancel. The answer stays valid until the
  /// next call.
  /// @throws WorkError  where transport cannot do with the memory that the scene allows.
  const Indirect& find(const Scene& scene, const SceneSurfaces& surfaces,
                       const SurfaceBuffer& buffer, const ProgressListener& listener = {},
                       const std::function<bool()>& stop = {});

  /// The last answer.
  const Indirect& found() const { return found_; }
  /// Whether the last answer is as good as it will get.
  bool is_complete() const { return is_complete_; }
  /// One line about the last answer, for people; empty where there was no indirect light.
  const std::string& told() const { return told_; }

  /// To be called before surfaces change.
  void forget() { transport_.reset(); }
  /// To be called when the buffer has changed since the last answer.
  void forget_view() { seen_.reset(); }

 private:
  void transport(const Scene& scene, const SceneSurfaces& surfaces, const SurfaceBuffer& buffer,
                 const ProgressListener& listener, const std::function<bool()>& stop);

  Denoiser denoiser_;
  std::optional<Transport> transport_;
  double memory_ = 0;
  std::optional<PixelBlend::Detail> seen_;  // how transport has seen the buffer
  bool is_complete_ = true;
  Indirect found_;
  std::optional<int> sky_bounces_;  // with which found_ has the open sky as it will stay
  std::string told_;
};

}  // namespace isolux
