#include "isolux/scene/option_value.h"

#include <gtest/gtest.h>

#include <functional>
#include <nlohmann/json.hpp>

#include "isolux/base/error.h"

namespace isolux {
namespace {

using nlohmann::json;

const Option& option(const char* name) { return *find_option(scene_options(), name); }

json parsed(const char* name, const char* text) {
  return value_from_text(option(name), text, std::string("--") + name);
}

std::string refusal(const char* name, const char* text) {
  try {
    parsed(name, text);
  } catch (const UsageError& error) {
    return error.what();
  }
  return "taken";
}

TEST(OptionValue, texts_become_json_and_back) {
  const std::pair<const char*, const char*> kTexts[] = {
      {"size", "640x480"},
      {"ambient", "0.1:0.2:0.3"},
      {"exposure", "1.5"},
      {"surface", "iso=-300,input=2,kd=1:0.79:0.6,shininess=10"},
      {"light", "point,at=0:0:57,color=1:0.5:0,space=index,falloff=inverse-square,reference=80"},
      {"camera", "view=left,projection=orthographic,height=108"},
  };
  for (const auto& [name, text] : kTexts) {
    EXPECT_EQ(text_from_value(option(name), parsed(name, text)), text);
  }
  EXPECT_EQ(parsed("light", "directional,to=1:0:0"), parsed("light", "to=1:0:0,kind=directional"));
}

TEST(OptionValue, every_mistake_names_its_place_and_a_remedy) {
  EXPECT_EQ(refusal("size", "640"), "--size: '640' is not a size; give it as 1024x768");
  EXPECT_EQ(refusal("ambient", "1:1"),
            "--ambient: '1:1' is not three numbers; give them as R:G:B, such as 0:0.5:1");
  EXPECT_EQ(refusal("surface", "iso=300,kx=1"),
            "--surface: has no field 'kx'; did you mean ka=...?");
  EXPECT_EQ(refusal("surface", "iso=300,kd=2:0:0"),
            "--surface kd: 2 is out of range; give from 0 to 1");
  EXPECT_EQ(refusal("surface", "iso=300,iso=400"), "--surface: iso is given twice; give it once");
  EXPECT_EQ(refusal("display", "gamma"),
            "--display: 'gamma' is none of its values; give one of srgb, raw");
  EXPECT_NE(refusal("light", "spot,at=0:0:0"), "taken");
  EXPECT_NE(refusal("exposure", "nan"), "taken");
  EXPECT_NE(refusal("spacing", "0:1:1"), "taken");
}

TEST(OptionValue, what_is_not_in_this_version_is_refused) {
  for (const char* name : {"transfer", "clip"}) {
    EXPECT_NE(refusal(name, "1"), "taken") << name;
  }
}

TEST(OptionTable, defaults_are_values_of_their_own_options) {
  const std::function<void(const std::vector<Option>&)> check = [&](const auto& options) {
    for (const Option& one : options) {
      EXPECT_FALSE(one.sentence.empty()) << one.name;
      if (!one.default_text.empty()) {
        EXPECT_NO_THROW(value_from_text(one, one.default_text, one.name)) << one.name;
      }
      check(one.fields);
    }
  };
  check(scene_options());
}

TEST(OptionTable, a_mistyped_name_finds_its_neighbour) {
  EXPECT_EQ(nearest_name(scene_options(), "suface"), "surface");
  EXPECT_EQ(nearest_name(scene_options(), "exposrue"), "exposure");
  EXPECT_EQ(nearest_name(scene_options(), "wireframe"), "");
}

}  // namespace
}  // namespace isolux
