#include "isolux/render/session.h"

#include <gtest/gtest.h>

#include <functional>
#include <nlohmann/json.hpp>

#include "isolux/scene/document.h"
#include "isolux/volume/phantom.h"

namespace isolux {
namespace {

using nlohmann::json;

class SessionTest : public testing::Test {
 protected:
  SessionTest() {
    document_["size"] = {24, 16};
    document_["surface"] = {{{"iso", 0.5}}, {{"iso", 0.7}}};
    document_["light"] = {{{"kind", "point"}, {"at", {-30, -60, 57}}}};
  }

  Scene scene() const {
    SceneDescription description = describe(document_, "scene");
    description.inputs = {"phantom:sphere"};
    return resolve(description, {{volume_}});
  }

  // What was rerun for the scene as it is now, after the picture was checked against one that is
  // drawn alone.
  Session::Counters rerun() {
    const Session::Counters before = session_.counters();
    const Scene now = scene();
    const Picture& picture = session_.picture(now);
    Session alone;
    EXPECT_EQ(picture.rgb, alone.picture(now).rgb);
    const Session::Counters after = session_.counters();
    return {after.skip_structure - before.skip_structure,
            after.visibility - before.visibility,
            after.shadows - before.shadows,
            after.indirect - before.indirect,
            after.lighting - before.lighting,
            after.display - before.display};
  }

  json document_ = empty_document();
  std::shared_ptr<const Volume> volume_ = std::make_shared<Volume>(sphere_phantom());
  Session session_;
};

constexpr Session::Counters kNothing{0, 0, 0, 0, 0, 0};
constexpr Session::Counters kDisplay{0, 0, 0, 0, 0, 1};
constexpr Session::Counters kLighting{0, 0, 0, 0, 1, 1};
constexpr Session::Counters kVisibility{0, 1, 0, 0, 1, 1};
constexpr Session::Counters kAll{1, 1, 0, 0, 1, 1};

TEST_F(SessionTest, the_first_picture_runs_every_stage_once_and_the_same_scene_none) {
  EXPECT_EQ(rerun(), kAll);
  EXPECT_EQ(rerun(), kNothing);
}

TEST_F(SessionTest, exposure_and_curve_rerun_the_display_alone) {
  rerun();
  document_["exposure"] = 0.5;
  EXPECT_EQ(rerun(), kDisplay);
  document_["display"] = "raw";
  EXPECT_EQ(rerun(), kDisplay);
}

TEST_F(SessionTest, a_lamp_a_material_ambient_or_background_rerun_lighting_and_no_eye_ray) {
  rerun();
  document_["light"][0]["at"] = {30, -60, 57};
  EXPECT_EQ(rerun(), kLighting);
  document_["light"].push_back({{"kind", "directional"}, {"to", {1, 0, 0}}});
  EXPECT_EQ(rerun(), kLighting);
  document_["surface"][0]["kd"] = {0.5, 0.1, 0.2};
  EXPECT_EQ(rerun(), kLighting);
  document_["ambient"] = {0.5, 0.1, 0.2};
  EXPECT_EQ(rerun(), kLighting);
  document_["background"] = {0.5, 0.1, 0.2};
  EXPECT_EQ(rerun(), kLighting);
}

TEST_F(SessionTest, camera_and_size_rerun_visibility_and_keep_the_skip_structure) {
  rerun();
  document_["camera"] = {{"view", "left"}};
  EXPECT_EQ(rerun(), kVisibility);
  document_["size"] = {16, 24};
  EXPECT_EQ(rerun(), kVisibility);
}

TEST_F(SessionTest, an_iso_value_or_another_volume_rerun_everything) {
  rerun();
  document_["surface"][0]["iso"] = 0.3;
  EXPECT_EQ(rerun(), kAll);
  volume_ = std::make_shared<Volume>(sphere_phantom(33));
  EXPECT_EQ(rerun(), kAll);
}

TEST_F(SessionTest, going_back_to_an_older_scene_gives_the_older_picture) {
  rerun();
  document_["exposure"] = 0.25;
  rerun();
  document_["light"][0]["at"] = {30, 0, 0};
  document_["exposure"] = 1;
  EXPECT_EQ(rerun(), kLighting);
}

TEST_F(SessionTest,
       with_shadows_a_lamp_that_moves_reruns_shadows_and_one_that_changes_colour_none) {
  document_["shadows"] = "on";
  EXPECT_EQ(rerun(), (Session::Counters{1, 1, 1, 0, 1, 1}));
  document_["light"][0]["at"] = {30, -60, 57};
  EXPECT_EQ(rerun(), (Session::Counters{0, 0, 1, 0, 1, 1}));
  document_["light"][0]["color"] = {1, 0.5, 0.2};
  EXPECT_EQ(rerun(), kLighting);
  document_["shadows"] = "off";
  EXPECT_EQ(rerun(), kLighting);
}

TEST_F(SessionTest, opacity_and_mirrors_rerun_visibility_and_a_lamp_behind_them_does_not) {
  rerun();
  document_["surface"][0]["opacity"] = 0.5;
  EXPECT_EQ(rerun(), kVisibility);
  document_["surface"][1]["kr"] = {0.5, 0.5, 0.5};
  EXPECT_EQ(rerun(), kVisibility);
  document_["light"][0]["at"] = {30, -60, 57};
  EXPECT_EQ(rerun(), kLighting);
  document_["mirror-depth"] = 1;
  EXPECT_EQ(rerun(), kVisibility);
}

// What was drawn before must not be seen in what is drawn now.
TEST_F(SessionTest, after_any_two_changes_in_any_order_the_picture_is_that_of_a_new_session) {
  const std::vector<json> changes = {
      {{"shadows", "on"}},
      {{"surface", {{{"iso", 0.5}, {"opacity", 0.5}}, {{"iso", 0.7}}}}},
      {{"surface", {{{"iso", 0.5}, {"kr", {0.5, 0.5, 0.5}}}, {{"iso", 0.7}}}}},
      {{"surface", {{{"iso", 0.6}}, {{"iso", 0.7}, {"kd", {0.5, 0.1, 0.2}}}}}},
      {{"light", {{{"kind", "point"}, {"at", {30, -60, 57}}}}}},
      {{"light", {{{"kind", "directional"}, {"to", {0, -1, 0}}, {"color", {1, 0.5, 0.2}}}}}},
      {{"ambient", {0.5, 0.1, 0.2}}},
      {{"background", {0.5, 0.1, 0.2}}},
      {{"camera", {{"view", "left"}}}},
      {{"size", {16, 24}}},
      {{"mirror-depth", 0}},
      {{"visibility", "raster"}},
      {{"exposure", 0.5}},
      {{"indirect", "path"}, {"spp", 1}},
      {{"indirect", "path"}, {"spp", 2}, {"denoise", "on"}},
      {{"indirect", "transport"}},
  };
  const auto expect_as_new = [&] {
    const Scene now = scene();
    Session alone;
    EXPECT_EQ(session_.picture(now).rgb, alone.picture(now).rgb);
    EXPECT_EQ(session_.direct_picture(now).rgb, alone.direct_picture(now).rgb);
    EXPECT_EQ(session_.radiance(now).total.r, alone.radiance(now).total.r);
  };
  const json beginning = document_;
  for (const json& first : changes) {
    for (const json& second : changes) {
      SCOPED_TRACE(first.dump() + " then " + second.dump());
      document_ = beginning;
      expect_as_new();
      for (const json& change : {first, second}) {
        if (change.contains("indirect")) {  // what another way had may not be its own
          document_.erase("spp");
          document_.erase("denoise");
        }
        document_.update(change);
        expect_as_new();
      }
      document_ = beginning;  // the first is taken back
      document_.update(second);
      expect_as_new();
    }
  }
}

TEST_F(SessionTest, what_moving_frames_have_sketched_is_not_seen_in_the_settled_picture) {
  document_["surface"] = {{{"iso", 0.5}}};
  document_["shadows"] = "on";
  document_["indirect"] = "transport";
  document_["light"] = {{{"kind", "point"}, {"at", {3, 2, 1}}}};
  document_["camera"] = {{"eye", {0, 4, 0}}, {"target", {0, -10, 0}}, {"up", {0, 0, 1}}};
  const auto expect_as_new = [&] {
    const Scene now = scene();
    Session alone;
    EXPECT_EQ(session_.indirect(now).pixels.g, alone.indirect(now).pixels.g);
    EXPECT_EQ(session_.indirect(now).sky, alone.indirect(now).sky);
    EXPECT_EQ(session_.picture(now).rgb, alone.picture(now).rgb);
  };
  for (const bool has_patience : {true, false}) {
    const auto move = [&] { session_.indirect(scene(), {}, [&] { return !has_patience; }); };
    for (int step = 1; step < 4; ++step) {
      document_["camera"]["target"] = {3 * step, -10, step};
      move();
    }
    expect_as_new();
    document_["light"][0]["at"] = {-4, 2, has_patience ? 3 : 2};
    move();
    expect_as_new();
    document_["camera"]["target"] = {-5, -10, has_patience ? 2 : 4};
    move();
    document_["light"][0]["color"] = {1, 0.5, 0.2};
    move();
    document_["bounces"] = has_patience ? 3 : 1;
    move();
    document_["light"][0].erase("color");
    expect_as_new();
  }
}

TEST_F(SessionTest, the_rasteriser_has_indirect_light_as_rays_have_also_when_it_comes_later) {
  // Inside a sphere of albedo 0.8 with a lamp near its middle: some 0.8 comes from all round.
  document_["surface"] = {{{"iso", 0.5}}};
  document_["light"] = {{{"kind", "point"}, {"at", {3, 2, 1}}}};
  document_["camera"] = {{"eye", {0, 0, 0}}, {"target", {0, -10, 0}}, {"up", {0, 0, 1}}};
  document_["visibility"] = "raster";
  rerun();
  document_["indirect"] = "path";
  document_["spp"] = 4;
  rerun();
  const Scene now = scene();
  const Indirect& found = session_.indirect(now);
  double least = 1;
  const SurfaceBuffer& buffer = session_.surfaces(now);
  for (std::size_t place = 0; place < buffer.pixels(); ++place) {
    if (buffer.is_hit(place)) least = std::min(least, found.pixels.at(place).g);
  }
  EXPECT_GT(least, 0.5);
}

}  // namespace
}  // namespace isolux
