#include "isolux/render/first_bounce.h"

#include <gtest/gtest.h>

#include "isolux/render/explanation.h"
#include "isolux/render/test_scenes.h"

namespace isolux {
namespace {

using nlohmann::json;

SceneInput plain(Mesh m, float x = 0) {
  m.colors.clear();
  for (auto& position : m.positions) position.x += x;
  return mesh(std::move(m));
}

const SceneInput kFloor = plain(square(0, 50, false));

json item(int input, double albedo) {
  return {{"input", input}, {"kd", {albedo, albedo, albedo}}, {"ks", {0, 0, 0}}};
}

// At the floor's middle, which the middle pixel shows; a lamp shines from below.
FirstBounce at_the_middle(const std::vector<SceneInput>& inputs, json settings) {
  settings.update({{"size", {33, 33}},
                   {"light", {{{"kind", "directional"}, {"to", {0, 0, -1}}}}},
                   {"camera", {{"eye", {0, -60, 30}}, {"target", {0, 0, 0}}, {"up", {0, 0, 1}}}},
                   {"indirect", "path"},
                   {"spp", 1}});
  const Explanation why = explain(scene_of(inputs, settings), 16, 16);
  EXPECT_NEAR(length(why.layers.at(0).terms.point.position), 0, 1e-4);
  return why.first_bounce;
}

// Two squares 40 mm above the floor, 12 mm wide, on either side of its middle, which is seen from
// both at the same angles: what they send is as their albedos. They face the lamp.
const SceneInput kRight = plain(square(40, 6, true), 20);
const SceneInput kLeft = plain(square(40, 6, true), -20);

TEST(FirstBounce, the_brighter_of_two_patches_is_named_first_with_its_place_and_share) {
  const FirstBounce first = at_the_middle({kFloor, kLeft, kRight},
                                          {{"surface", {item(1, 0.8), item(2, 0.2), item(3, 1)}}});
  ASSERT_GE(first.senders.size(), 2u);
  for (const std::size_t n : {0u, 1u}) {
    EXPECT_EQ(first.senders[n].surface, n == 0 ? 2 : 1);
    const Vec3 place = first.senders[n].position;
    EXPECT_NEAR(place.x, n == 0 ? 20 : -20, 6);
    EXPECT_NEAR(place.y, 0, 6);
    EXPECT_NEAR(place.z, 40, 1e-4);
  }
  EXPECT_NEAR(first.senders[0].share, 1 / 1.2, 0.04);
  EXPECT_NEAR(first.senders[1].share, 0.2 / 1.2, 0.04);
  EXPECT_EQ(first.sky_share, 0);
}

TEST(FirstBounce, what_is_seen_through_a_veil_counts_by_what_the_veil_leaves) {
  // A black sheet of opacity 0.75 half way to the right patch leaves 0.25 of it, beside the left
  // one's 0.4, of which its own opacity of 0.5 leaves 0.2.
  json veil = item(4, 0);
  veil["opacity"] = 0.75;
  json left = item(2, 0.4);
  left["opacity"] = 0.5;
  const FirstBounce first = at_the_middle({kFloor, kLeft, kRight, plain(square(20, 8, true), 10)},
                                          {{"surface", {item(1, 0.8), left, item(3, 1), veil}}});
  ASSERT_GE(first.senders.size(), 2u);
  EXPECT_EQ(first.senders[0].surface, 2);
  EXPECT_NEAR(first.senders[0].share, 0.25 / 0.45, 0.05);
}

TEST(FirstBounce, places_in_shadow_send_nothing) {
  // The floor stands between the lamp and the patches.
  const FirstBounce first =
      at_the_middle({kFloor, kLeft, kRight},
                    {{"surface", {item(1, 0.8), item(2, 0.2), item(3, 1)}}, {"shadows", "on"}});
  EXPECT_TRUE(first.senders.empty());
}

TEST(FirstBounce, an_open_floor_has_all_from_the_sky) {
  const FirstBounce first =
      at_the_middle({kFloor}, {{"surface", {item(1, 0.8)}}, {"ambient", {1, 1, 1}}});
  EXPECT_TRUE(first.senders.empty());
  EXPECT_EQ(first.sky_share, 1);
  EXPECT_NEAR(first.light, 1, 1e-12);
}

}  // namespace
}  // namespace isolux
