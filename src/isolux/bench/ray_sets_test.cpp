#include "isolux/bench/ray_sets.h"

#include <gtest/gtest.h>

#include <fstream>

#include "isolux/base/error.h"
#include "isolux/bench/loose_rays.h"
#include "isolux/bench/own_renderer.h"
#include "isolux/volume/phantom.h"
#include "temporary_folder.h"

namespace isolux {
namespace {

class RaySets : public TemporaryFolder {
 protected:
  RaySets() : ball_(bench_scene(std::make_shared<Volume>(sphere_phantom(33)), 0.5, 160, 160)) {
    ball_.prepare();
    ball_.frame();
  }
  const Camera& camera() const { return *ball_.scene().camera; }
  LooseRays tracer() const { return LooseRays(ball_.scene().surfaces[0]); }

  OwnRenderer ball_;
};

TEST_F(RaySets, ThereIsOneRayForEachPixelThatIsHit) {
  EXPECT_GT(ball_.hit_pixels(), 1000u);
  EXPECT_EQ(cosine_rays(camera(), ball_.surfaces()).size(), ball_.hit_pixels());
  EXPECT_EQ(shadow_rays(camera(), ball_.surfaces(), {0, 0, 900}).size(), ball_.hit_pixels());
}

// Over a hemisphere with density cos / pi, the mean of the cosine is 2 / 3. A convex ball is never
// met again by rays that leave it.
TEST_F(RaySets, CosineRaysLeaveTheBallWithAMeanCosineOfTwoThirds) {
  double sum = 0;
  const std::vector<Ray> rays = cosine_rays(camera(), ball_.surfaces());
  for (const Ray& ray : rays) {
    EXPECT_NEAR(length(ray.direction), 1, 1e-12);
    sum += dot(normalize(ray.origin), ray.direction);
  }
  // The variance of the cosine is 1/2 - 4/9 = 1/18: five standard errors for that many rays.
  const double count = static_cast<double>(rays.size());
  EXPECT_NEAR(sum / count, 2. / 3, 5 * std::sqrt(1 / (18 * count)) + 0.005);
  EXPECT_EQ(tracer().count_hits(rays), 0u);
}

TEST_F(RaySets, ShadowRaysGoToTheLampAndMeetTheBallBehindItsHorizon) {
  const Vec3 behind{0, 900, 0};  // the eye is at -y
  const std::vector<Ray> rays = shadow_rays(camera(), ball_.surfaces(), behind);
  for (const Ray& ray : rays) {
    EXPECT_NEAR(length(cross(normalize(behind - ray.origin), ray.direction)), 0, 1e-12);
  }
  EXPECT_GT(tracer().count_hits(rays, behind), rays.size() * 9 / 10);
}

TEST_F(RaySets, AFileGivesTheRaysBackAsFloats) {
  const std::string path = folder_ / "rays";
  write_rays(path, {{{0.5, -2, 3}, {0, 0, -1}}, {{1e3, 0, 0}, {0.25, 0.5, 1}}});
  const std::vector<Ray> rays = read_rays(path);
  ASSERT_EQ(rays.size(), 2u);
  EXPECT_EQ(rays[0].origin, (Vec3{0.5, -2, 3}));
  EXPECT_EQ(rays[1].direction, (Vec3{0.25, 0.5, 1}));
  EXPECT_THROW(read_rays(folder_ / "none"), WorkError);
}

}  // namespace
}  // namespace isolux
