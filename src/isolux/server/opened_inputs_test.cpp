#include "isolux/server/opened_inputs.h"

#include <gtest/gtest.h>

#include "isolux/base/error.h"
#include "isolux/volume/phantom.h"

namespace isolux {
namespace {

using nlohmann::json;

ReadResult sphere(const std::string& name) {
  ReadResult result;
  result.volume = std::make_shared<Volume>(sphere_phantom(9));
  result.name = name;
  return result;
}

json naming(const std::string& name) { return {{"input", {name}}}; }

TEST(OpenedInputs, a_dropped_file_of_a_name_that_is_taken_gets_another) {
  OpenedInputs inputs;
  EXPECT_EQ(inputs.add(sphere("head.nrrd"), json::object(), false), "head.nrrd");
  EXPECT_EQ(inputs.add(sphere("head.nrrd"), json::object(), true), "head.nrrd (2)");
  EXPECT_EQ(inputs.add(sphere("head.nrrd"), json::object(), true), "head.nrrd (3)");
  EXPECT_NE(inputs.inputs_of(naming("head.nrrd")), inputs.inputs_of(naming("head.nrrd (2)")));
}

TEST(OpenedInputs, of_dropped_files_the_last_four_stay_open_and_named_ones_always) {
  OpenedInputs inputs;
  inputs.add(sphere("named"), json::object(), false);
  for (const char* name : {"1", "2", "3", "4", "5"}) inputs.add(sphere(name), json::object(), true);
  EXPECT_THROW(inputs.inputs_of(naming("1")), WorkError);
  for (const char* name : {"named", "2", "3", "4", "5"}) {
    EXPECT_NO_THROW(inputs.inputs_of(naming(name))) << name;
  }
}

TEST(OpenedInputs, a_scene_that_reads_an_input_another_way_is_refused) {
  OpenedInputs inputs;
  inputs.add(sphere("a"), {{"spacing", {2, 2, 2}}}, false);
  json document = naming("a");
  EXPECT_THROW(inputs.inputs_of(document), UsageError);
  document["spacing"] = {2, 2, 2};
  EXPECT_NO_THROW(inputs.inputs_of(document));
}

}  // namespace
}  // namespace isolux
