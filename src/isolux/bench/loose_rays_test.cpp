#include "isolux/bench/loose_rays.h"

#include <gtest/gtest.h>

#include "isolux/bench/own_renderer.h"
#include "isolux/bench/ray_sets.h"
#include "isolux/volume/phantom.h"

namespace isolux {
namespace {

TEST(LooseRays, AsManyHitAsThePlainWalkerFinds) {
  const auto volume = std::make_shared<const Volume>(head_phantom(40));
  OwnRenderer head(bench_scene(volume, 300, 160, 160));
  head.prepare();
  head.frame();
  std::vector<Ray> rays = cosine_rays(*head.scene().camera, head.surfaces());
  rays.resize(rays.size() / 16 * 16 + 5);  // the last packet is not full
  const auto bricks = std::make_shared<const BrickGrid>(*volume);
  const IsoSurface plain(volume, bricks, 300);
  std::size_t wanted = 0;
  for (const Ray& ray : rays) wanted += plain.first_hit(ray).has_value();
  EXPECT_GT(wanted, 100u);
  EXPECT_LT(wanted, rays.size());
  const LooseRays lanes(head.scene().surfaces[0]);
  EXPECT_EQ(lanes.count_hits(rays), wanted);
}

}  // namespace
}  // namespace isolux
