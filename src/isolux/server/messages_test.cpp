#include "isolux/server/messages.h"

#include <gtest/gtest.h>

#include <string>

#include "isolux/base/error.h"

namespace isolux {
namespace {

constexpr const char* kView =
    R"({"type":"view","id":7,"scene":{},"show":["picture","cos-theta"],"light":1,"settled":true})";

TEST(Messages, a_view_request_is_read_whole) {
  const auto request = std::get<ViewRequest>(parse_message(kView));
  EXPECT_EQ(request.id, 7);
  EXPECT_EQ(request.show, (std::vector{ShownLayer::kPicture, ShownLayer::kCosTheta}));
  EXPECT_EQ(request.light, 1u);
  EXPECT_TRUE(request.settled);
}

TEST(Messages, what_is_not_exactly_one_of_them_is_refused) {
  for (const char* text : {
           "",
           "[]",
           "{}",
           "null",
           R"({"type":7})",
           R"({"type":"shutdown"})",
           R"({"type":"ack"})",
           R"({"type":"ack","id":-1})",
           R"({"type":"ack","id":1.5})",
           R"({"type":"ack","id":"1"})",
           R"({"type":"ack","id":1e300})",
           R"({"type":"ack","id":1,"path":"/etc/passwd"})",
           R"({"type":"stop"})",
           R"({"type":"pick","id":1,"at":[0.5]})",
           R"({"type":"pick","id":1,"at":[1,0]})",
           R"({"type":"pick","id":1,"at":[-0.1,0]})",
           R"({"type":"explain","id":1,"scene":{},"pixel":[0.5,1]})",
           R"({"type":"view","id":7,"scene":{},"show":[],"light":1,"settled":true})",
           R"({"type":"view","id":7,"scene":{},"show":["x"],"light":1,"settled":true})",
           R"({"type":"view","id":7,"scene":{},"show":["depth","depth","depth"],"light":1,)"
           R"("settled":true})",
           R"({"type":"view","id":7,"scene":{},"show":["depth"],"light":-1,"settled":true})",
           R"({"type":"view","id":7,"scene":{},"show":["depth"],"light":1,"settled":1})",
       }) {
    EXPECT_THROW(parse_message(text), UsageError) << text;
  }
}

TEST(Messages, nothing_nests_deeper_than_what_can_be_walked_through) {
  const std::string deep = std::string(100'000, '[') + std::string(100'000, ']');
  EXPECT_THROW(parse_json(deep), UsageError);
  EXPECT_NO_THROW(parse_json("[[[[[[1]]]]]]"));
}

}  // namespace
}  // namespace isolux
