#include "isolux/bench/work.h"

#include <gtest/gtest.h>

namespace isolux {
namespace {

std::function<double(int)> logging(std::string& log, char name, double ms) {
  return [&log, name, ms](int turn) {
    log += name + std::to_string(turn) + " ";
    return ms * (turn + 1);
  };
}

TEST(Work, TurnsAreInterleavedPairByPairAfterOneToWarmUp) {
  std::string log;
  measure({"frame",
           2,
           logging(log, 'o', 1),
           {{"a", logging(log, 'a', 2)}, {"b", logging(log, 'b', 3)}}});
  EXPECT_EQ(log, "o2 a2 b2 o0 a0 o0 b0 o1 a1 o1 b1 ");
}

TEST(Work, ARatioIsTheirTimeOverOursInTheSameTurn) {
  std::string log;
  const Measurement result =
      measure({"frame", 3, logging(log, 'o', 2), {{"a", logging(log, 'a', 5)}}});
  EXPECT_EQ(result.ms, (std::vector<double>{2, 4, 6}));
  EXPECT_EQ(result.comparisons[0].ms, (std::vector<double>{5, 10, 15}));
  EXPECT_EQ(result.comparisons[0].ratios, (std::vector<double>{2.5, 2.5, 2.5}));
}

TEST(Work, ASlowOneTakesPartInEveryNthTurnAlone) {
  std::string log;
  measure({"frame",
           4,
           logging(log, 'o', 1),
           {{"fast", logging(log, 'f', 1)}, {"slow", logging(log, 's', 1), 3}}});
  EXPECT_EQ(log, "o4 f4 s4 o0 f0 o0 s0 o1 f1 o2 f2 o3 f3 o3 s3 ");
}

TEST(Work, WithoutOthersIsoluxTurnsAlone) {
  std::string log;
  EXPECT_EQ(measure({"frame", 3, logging(log, 'o', 1)}).ms.size(), 3);
  EXPECT_EQ(log, "o3 o0 o1 o2 ");
}

}  // namespace
}  // namespace isolux
