#include "isolux/server/drawing.h"

#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "isolux/image/png.h"
#include "isolux/scene/document.h"
#include "isolux/volume/phantom.h"

namespace isolux {
namespace {

using nlohmann::json;

struct Frame {
  json header;
  std::string file;
};

Frame unpacked(const std::string& bytes) {
  std::size_t length = 0;
  for (int n = 3; n >= 0; --n) {
    length = length << 8 | static_cast<unsigned char>(bytes[static_cast<std::size_t>(n)]);
  }
  return {json::parse(bytes.substr(4, length)), bytes.substr(4 + length)};
}

TEST(Drawing, paths_are_seen_at_once_while_a_lamp_moves_and_settle_to_the_picture_of_render) {
  const std::vector<SceneInput> inputs = {{std::make_shared<const Volume>(head_phantom(32))}};
  json document = empty_document();
  document.update({{"size", {160, 160}},
                   {"surface", {{{"iso", 300}}}},
                   {"light", {{{"kind", "point"}, {"at", {-90, -200, 60}}}}},
                   {"shadows", "on"},
                   {"indirect", "path"},
                   {"spp", 3}});
  Drawing drawing;
  const auto frame = [&](bool is_settled) {
    SceneDescription description = describe(document, "scene");
    description.inputs = {"head"};
    const ViewRequest request{
        .id = 1, .scene = document, .show = {ShownLayer::kPicture}, .settled = is_settled};
    return unpacked(drawing.frame(request, description, inputs, 0, {}));
  };
  int found = 0;
  for (const double x : {-90, -60, 40}) {
    document["light"][0]["at"][0] = x;
    const Frame moving = frame(false);
    EXPECT_EQ(moving.header["type"], "image/jpeg");
    EXPECT_EQ(moving.header["counters"]["indirect"], ++found);
  }
  for (const char* denoise : {"off", "on"}) {
    document["denoise"] = denoise;
    frame(false);
    const Frame settled = frame(true);
    SceneDescription description = describe(document, "scene");
    description.inputs = {"head"};
    Session alone;
    const Picture& picture = alone.picture(resolve(description, inputs));
    EXPECT_EQ(settled.header["size"], json({160, 160}));
    EXPECT_TRUE(settled.file == encode_png(picture, {}, false, PngEffort::kFast)) << denoise;
  }
}

}  // namespace
}  // namespace isolux
