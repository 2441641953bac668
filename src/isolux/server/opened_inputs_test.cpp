#include "isolux/server/opened_inputs.h"

#include <gtest/gtest.h>

#include "isolux/base/error.h"
#include "isolux/base/memory.h"
#include "isolux/volume/phantom.h"

namespace isolux {
namespace {

using nlohmann::json;

ReadResult sphere(const std::string& name) {
  ReadResult result;
  result.volume = std::make_shared<Volume>(sphere_phantom(9));  // 9^3 floats: 2916 bytes
  result.name = name;
  return result;
}

json naming(const std::string& name) { return {{"input", {name}}}; }

TEST(OpenedInputs, a_dropped_file_of_a_name_that_is_taken_gets_another) {
  OpenedInputs inputs;
  EXPECT_EQ(inputs.add(sphere("head.nrrd"), json::object(), false), "head.nrrd");
  EXPECT_EQ(inputs.add(sphere("head.nrrd"), json::object(), true), "head.nrrd (2)");
  EXPECT_EQ(inputs.add(sphere("head.nrrd"), json::object(), true), "head.nrrd (3)");
  EXPECT_NE(inputs.volumes_of(naming("head.nrrd")), inputs.volumes_of(naming("head.nrrd (2)")));
}

TEST(OpenedInputs, the_oldest_dropped_file_makes_room) {
  OpenedInputs inputs;
  inputs.add(sphere("named"), json::object(), false);
  set_memory_limit(3.5 * 2916);  // the named one and two dropped ones
  inputs.add(sphere("first"), json::object(), true);
  inputs.add(sphere("second"), json::object(), true);
  inputs.add(sphere("third"), json::object(), true);
  EXPECT_THROW(inputs.volumes_of(naming("first")), WorkError);
  EXPECT_NO_THROW(inputs.volumes_of(naming("second")));
  EXPECT_NO_THROW(inputs.volumes_of(naming("named")));
  set_memory_limit(1.5 * 2916);
  EXPECT_THROW(inputs.add(sphere("fourth"), json::object(), true), WorkError);
  EXPECT_NO_THROW(inputs.volumes_of(naming("named")));
  set_memory_limit(1e12);
}

TEST(OpenedInputs, a_scene_that_reads_an_input_another_way_is_refused) {
  OpenedInputs inputs;
  inputs.add(sphere("a"), {{"spacing", {2, 2, 2}}}, false);
  json document = naming("a");
  EXPECT_THROW(inputs.volumes_of(document), UsageError);
  document["spacing"] = {2, 2, 2};
  EXPECT_NO_THROW(inputs.volumes_of(document));
}

}  // namespace
}  // namespace isolux
