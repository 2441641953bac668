#include "isolux/bench/own_renderer.h"

#include <gtest/gtest.h>

#include "isolux/bench/limits.h"
#include "isolux/render/session.h"
#include "isolux/volume/phantom.h"

namespace isolux {
namespace {

OwnRenderer ball(double iso) {
  return OwnRenderer(bench_scene(std::make_shared<Volume>(sphere_phantom(17)), iso, 24, 24));
}

// What is timed is what a user gets.
TEST(OwnRenderer, AFrameHasTheBytesOfASessionsPicture) {
  OwnRenderer timed = ball(0.5);
  timed.prepare();
  timed.frame();
  EXPECT_EQ(timed.picture().rgb, Session().picture(timed.scene()).rgb);
  timed.set_iso(0.25);
  timed.set_lamp(Vec3{-100, -200, 300});
  timed.look(close_view({64, 64, 64}, 30));
  timed.prepare();
  timed.frame();
  EXPECT_EQ(timed.picture().rgb, Session().picture(timed.scene()).rgb);
}

TEST(OwnRenderer, AFrameOfPathsHasTheBytesOfASessionsPicture) {
  OwnRenderer timed = ball(0.5);
  timed.prepare();
  timed.frame();
  const auto direct = timed.picture().rgb;
  timed.set_lamp(Vec3{-100, -200, 300});
  timed.set_paths(3, 2);
  timed.frame();
  EXPECT_EQ(timed.picture().rgb, Session().picture(timed.scene()).rgb);
  EXPECT_NE(timed.picture().rgb, direct);
}

TEST(OwnRenderer, TheHeadlightFollowsTheEyeAndComesBackAfterALamp) {
  OwnRenderer renderer = ball(0.5);
  const View elsewhere{{200, 30, 10}, {0, 0, 0}, 30};
  renderer.look(elsewhere);
  const Vec3 to_eye = normalize(elsewhere.eye - elsewhere.target);
  EXPECT_NEAR(length(renderer.scene().lights[0].place - to_eye), 0, 1e-12);
  renderer.set_lamp(Vec3{1, 2, 3});
  EXPECT_EQ(renderer.scene().lights[0].place, (Vec3{1, 2, 3}));
  renderer.set_lamp(std::nullopt);
  EXPECT_NEAR(length(renderer.scene().lights[0].place - to_eye), 0, 1e-12);
}

TEST(Limits, ReadingEveryVoxelSumsTheirWords) {
  Volume volume = sphere_phantom(4);
  std::vector<std::int16_t> voxels(64, 0);
  voxels[0] = 5;   // the lowest 16 bits of the first word
  voxels[4] = 7;   // those of the second
  voxels[63] = 1;  // the highest of the last
  volume.voxels = voxels;
  EXPECT_EQ(read_voxels_once(volume), 12 + (std::uint64_t{1} << 48));
}

}  // namespace
}  // namespace isolux
