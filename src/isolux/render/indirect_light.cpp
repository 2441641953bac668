#include "isolux/render/indirect_light.h"

#include <chrono>
#include <cmath>
#include <optional>

#include "isolux/base/error.h"
#include "isolux/base/memory.h"
#include "isolux/base/number_text.h"
#include "isolux/render/denoise.h"
#include "isolux/render/path_tracer.h"

namespace isolux {

const Indirect& IndirectLight::find(const Scene& scene, const SceneSurfaces& surfaces,
                                    const SurfaceBuffer& buffer, const ProgressListener& listener,
                                    const std::function<bool()>& stop) {
  is_complete_ = true;
  told_.clear();
  if (scene.indirect == IndirectMethod::kTransport) {
    transport(scene, surfaces, buffer, listener, stop);
    return found_;
  }
  found_ = {};
  sky_bounces_.reset();
  if (scene.indirect == IndirectMethod::kPath) {
    PathTracer tracer(scene, surfaces);
    tracer.run(buffer, listener);
    told_ = std::to_string(tracer.samples()) + " samples a pixel";
    if (tracer.samples() > 1) {  // one cannot tell
      told_ += ", error " + to_text(std::round(1e4 * tracer.relative_error()) / 100) + " % or less";
    }
    found_ = tracer.indirect(buffer);
    if (scene.denoise) {
      denoiser_.denoise(*scene.camera, buffer, tracer.variances(), found_.pixels);
      told_ += ", then denoised";
    }
  }
  return found_;
}

void IndirectLight::transport(const Scene& scene, const SceneSurfaces& surfaces,
                              const SurfaceBuffer& buffer, const ProgressListener& listener,
                              const std::function<bool()>& stop) {
  if (!transport_ || memory_ != scene.indirect_memory) {
    transport_.emplace(scene, surfaces, TransportOptions{.memory = scene.indirect_memory});
    memory_ = scene.indirect_memory;
    seen_.reset();
  }
  if (!seen_ || (!stop && seen_ != PixelBlend::Detail::kWhole)) {
    seen_ = stop ? PixelBlend::Detail::kSketch : PixelBlend::Detail::kWhole;
    transport_->see(scene, buffer, *seen_);
    sky_bounces_.reset();
  }
  // To count takes milliseconds, and the question comes every few of them.
  using Clock = std::chrono::steady_clock;
  constexpr auto kBetweenCounts = std::chrono::milliseconds(100);
  std::optional<Clock::time_point> counted;
  double done = 0;
  is_complete_ = transport_->refine(scene.bounces, [&] {
    if (listener) {
      if (!counted || Clock::now() - *counted >= kBetweenCounts) {
        done = transport_->done();
        counted = Clock::now();
      }
      listener("linking surfaces", done);
    }
    return stop && stop();
  });
  if (transport_->bytes() > scene.indirect_memory) {
    const std::string bytes = bytes_text(transport_->bytes());
    transport_.reset();
    throw WorkError("--indirect-memory", "even the fewest samples and links take " + bytes,
                    "allow more, or draw fewer pixels");
  }
  transport_->light(scene);
  transport_->gather(buffer, found_);
  if (seen_ == PixelBlend::Detail::kSketch) {
    found_.sky.resize(buffer.pixels());
  } else if (sky_bounces_ != scene.bounces) {
    transport_->gather_sky(buffer, found_);
  }
  sky_bounces_.reset();
  if (is_complete_) sky_bounces_ = scene.bounces;
  told_ =
      std::to_string(transport_->links()) + " links a sample, " + bytes_text(transport_->bytes());
}

}  // namespace isolux
