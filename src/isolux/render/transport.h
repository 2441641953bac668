#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <vector>

#include "isolux/render/close_light.h"
#include "isolux/render/indirect.h"
#include "isolux/render/link_sums.h"
#include "isolux/render/pixel_blend.h"
#include "isolux/render/scene_surfaces.h"
#include "isolux/render/surface_buffer.h"
#include "isolux/render/surface_samples.h"
#include "isolux/render/transport_links.h"
#include "isolux/scene/scene.h"

namespace isolux {

struct TransportOptions {
  /// Links of each sample that the picture is blended of; those between which light goes to and fro
  /// have a sixteenth of them, and 8 at least. A power of 2, at least 8.
  int links = 256;
  double memory = 1e9;  ///< bytes; see Transport::bytes
};

/// Indirect light that follows the lamp: cached transport between samples of the surfaces. After
/// Hasan, Pellacini and Bala 2006, "Direct-to-indirect transfer for cinematic relighting", which
/// gathers from samples of the surfaces at samples of the picture; here both are in the scene, so
/// that they outlive the picture, and light goes on between them from bounce to bounce.
///
/// There are two sets of samples: fine ones, of which the points of a picture are blended, and
/// coarse ones, which send light to these and to each other. Rays are shot once, and for those
/// samples alone that the picture needs: the fine ones that it is blended of, the coarse ones that
/// they see, those that these see, and so on for as many bounces as there are. From then on,
/// whatever happens to lamps, colours and ambient light costs one shadow ray for each coarse sample
/// and lamp, and one mean over links for each sample and bounce; nothing of it is random from frame
/// to frame.
///
/// Keeps references to the scene's surfaces; the volumes and meshes must stay as they are.
class Transport {
 public:
  Transport(const Scene& scene, const SceneSurfaces& surfaces, TransportOptions options = {});

  /// Says what picture is to be lit: how its points are blended of samples. What is known of these
  /// from pictures before is kept; after a sketch, what its picture needed as well. The buffer must
  /// stay as it is until the next one is seen.
  void see(const Scene& scene, const SurfaceBuffer& buffer,
           PixelBlend::Detail detail = PixelBlend::Detail::kWhole);

  /// Shoots the links that are missing: first 8 everywhere, and for a sketch no more, then 16, and
  /// so on; and at last, but for a sketch, those from pixels to what is close to them, which count
  /// when there are all. Asks `stop` in between, every few milliseconds. Returns whether there are
  /// all.
  bool refine(int bounces, const std::function<bool()>& stop = {});
  /// How much of that is done, in [0, 1].
  double done() const;

  /// Finds the light at all samples that are needed; where lamps, colours and ambient light are as
  /// they were, at those alone where it is not known.
  void light(const Scene& scene);

  /// E at all points of the picture.
  void gather(const SurfaceBuffer& buffer, Indirect& indirect) const;
  /// The open sky there, which stays as it is until links or the picture change.
  void gather_sky(const SurfaceBuffer& buffer, Indirect& indirect) const;

  /// Links of a fine sample: fewer than asked for where memory does not reach.
  int links() const { return links_; }
  /// Of memory: some 110 for each site (a place with samples) and its block; 64 for each coarse
  /// sample, 12 more for each bounce beyond two, and 4 for each fine one, four a site; some 110 for
  /// each of these that the picture is blended of; 8 for each link; 36 for each pair of a block of
  /// 16 pixels and a sample that counts there. Blocks of samples are made larger where sites alone
  /// would take more than half the limit; then links are halved, down to 16.
  double bytes() const;

 private:
  int coarse_links() const;
  void follow(const SampleLinks& row, std::uint16_t& followed, std::int8_t bounces);
  void collect(std::int8_t bounces);
  bool shoot_coarse(int bounces, int count, bool is_whole, const std::function<bool()>& stop);
  bool shoot_close(int bounces, const std::function<bool()>& stop);
  void light_directly(const Scene& scene, const std::vector<std::uint32_t>& sources);
  void set_albedo(const Scene& scene, const std::vector<std::uint32_t>& sources);
  void send(const std::vector<std::uint32_t>& sources, std::size_t bounce, SentLight& light);
  void keep_known(const std::vector<std::uint32_t>& before);
  bool shoot(TransportLinks& links, const std::vector<std::uint32_t>& samples, int count,
             const std::function<bool()>& stop);

  const SceneSurfaces& surfaces_;
  TransportOptions options_;
  int links_;
  std::unique_ptr<SurfaceSamples> fine_, coarse_;
  std::unique_ptr<TransportLinks> from_fine_, from_coarse_;
  std::optional<PixelBlend> blend_;
  const SurfaceBuffer* buffer_ = nullptr;  // the picture that was seen last
  std::optional<Camera> camera_;           // its camera
  std::optional<CloseLight> close_;        // of it, once all other links are there
  bool has_room_for_close_ = true;
  bool is_close_known_ = false;  // whether what it leads to has its needs, and their links
  bool is_close_lit_ = false;    // whether fine_light_ is that from further away
  int bounces_ = -1;
  int refined_ = 0;  // how many links all samples have that need any, if they shall have as many
  // For each coarse sample: how many bounces of light must be known there (0: direct light alone;
  // -1: nothing at all), the same as it was collected last, and how many of its links have been
  // followed for that.
  std::vector<std::int8_t> needs_, collected_;
  std::vector<std::uint16_t> followed_;
  std::vector<std::vector<std::uint32_t>> needing_;  // coarse samples by their needs
  std::vector<std::uint16_t> fine_followed_;         // in the order of blend_->samples()
  std::vector<std::uint32_t> sources_;               // all coarse samples with a need
  // Light has one channel where all of it is grey, else three, side by side for each sample.
  std::size_t channels_ = 1;
  std::vector<float> direct_;             // D
  std::vector<float> albedo_;             // kd
  std::vector<std::vector<float>> sent_;  // kd (D + E), by the bounces in E
  std::optional<Scene> lit_by_;
  int lit_bounces_ = -1;
  std::vector<std::int8_t> known_;  // of each coarse sample: for how many bounces sent_ is right
  // In the order of blend_->samples(): their light, and with how many rays it was found.
  std::vector<SlopedLight> fine_light_;
  std::vector<std::uint16_t> fine_rays_;
  std::vector<SlopedLight> all_fine_light_;  // with what is close, where further points need that
};

}  // namespace isolux
