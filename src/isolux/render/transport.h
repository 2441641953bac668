#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <vector>

#include "isolux/render/indirect.h"
#include "isolux/render/pixel_blend.h"
#include "isolux/render/scene_surfaces.h"
#include "isolux/render/surface_buffer.h"
#include "isolux/render/surface_samples.h"
#include "isolux/render/transport_links.h"
#include "isolux/scene/scene.h"

namespace isolux {

struct TransportOptions {
  /// Links of each sample that pixels are blended of; those that light only reaches in between have
  /// a quarter of them. A power of 2, at least 8.
  int links = 256;
  double memory = 1e9;  ///< bytes; see Transport
};

/// Indirect light that follows the lamp: cached transport between samples of the surfaces. After
/// Hašan, Pellacini and Bala 2006, "Direct-to-indirect transfer for cinematic relighting", but from
/// all samples to all, so that light goes on from bounce to bounce.
///
/// Rays are shot once, for those samples alone that the picture needs: from the samples that its
/// points are blended of, from those that these see, and so on for as many bounces as there are.
/// From then on, whatever happens to lamps, colours and ambient light costs one shadow ray for each
/// sample and lamp, and one mean over links for each sample and bounce; nothing of it is random
/// from frame to frame.
///
/// Memory, in bytes, at most: S (136 + 4 N) + 36 P, with S samples of N links and P weights of
/// pixels. Where S (136 + 4 N) would exceed the limit, links are halved down to 32, and then blocks
/// made larger, up to 4^3 cells.
///
/// Keeps references to the scene's surfaces; the volumes and meshes must stay as they are.
class Transport {
 public:
  Transport(const Scene& scene, const SceneSurfaces& surfaces, TransportOptions options = {});

  /// Says what picture is to be lit: how its points are blended of samples.
  void see(const Scene& scene, const SurfaceBuffer& buffer);

  /// Shoots links that are missing: first 8 everywhere, then 16, and so on. Asks `stop` in between,
  /// every few milliseconds. Returns whether there are all.
  bool refine(int bounces, const std::function<bool()>& stop = {});
  /// Links of the samples in the picture by now, as a share of those there will be.
  double done() const;

  /// Finds the light at all samples that are needed.
  void light(const Scene& scene);

  /// E at all points of the picture.
  void gather(const SurfaceBuffer& buffer, Indirect& indirect) const;

  const SurfaceSamples& samples() const { return *samples_; }
  const TransportLinks& links() const { return *links_; }
  int links_a_sample() const { return options_.links; }
  double bytes() const;
  std::size_t source_count() const { return sources_.size(); }
  std::size_t picture_count() const { return blend_->samples().size(); }

 private:
  // Radiance on its way: that which leaves a sample; the fourth number is not used.
  using Radiance4 = std::array<float, 4>;

  static constexpr std::int8_t kUnneeded = -1;

  std::size_t wanted(std::int8_t need) const;
  bool refine_round(std::size_t count, const std::function<bool()>& stop);
  void need(std::uint32_t sample, std::int8_t bounces);
  void follow(std::uint32_t sample);
  void light_directly(const Scene& scene);
  void set_albedo(const Scene& scene);

  const SceneSurfaces& surfaces_;
  TransportOptions options_;
  std::unique_ptr<SurfaceSamples> samples_;
  std::unique_ptr<TransportLinks> links_;
  std::optional<PixelBlend> blend_;
  int bounces_ = 0;
  // For each sample, how many bounces of light must be known there: 0: direct light alone.
  std::vector<std::int8_t> needs_;
  // Samples by their needs, in the order in which they are found.
  std::vector<std::vector<std::uint32_t>> needing_;
  std::vector<std::uint16_t>
      followed_;                 // how many links of each sample have been looked at for needs
  std::vector<bool> is_source_;  // whether a link that is followed leads there
  std::vector<std::uint32_t> sources_;   // these, in order
  std::vector<Radiance4> direct_;        // D
  std::vector<Radiance4> albedo_;        // kd
  std::vector<Radiance4> sent_, next_;   // kd (D + E) of samples, sky, dark
  std::vector<SampleLight> irradiance_;  // E and sky of the samples in the picture
};

}  // namespace isolux
