#include "isolux/bench/table.h"

#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

namespace isolux {
namespace {

Report of_one_row(const Measurement& row) {
  Report report;
  report.sections = {{"bone", {row}}};
  return report;
}

TEST(BenchTable, RatiosAreMediansOverPairsNotRatiosOfMedians) {
  // Medians 4 and 6 would give 1.5; the pairs are 3, 1.5 and 1.25 times as slow.
  const Measurement row{"frame", "", 0, {1, 4, 8}, {{"peer", "", {3, 6, 10}, {3, 1.5, 1.25}}}, -1};
  const auto json = report_json(of_one_row(row))["rows"];
  EXPECT_EQ(json[0]["median"], 4);
  EXPECT_EQ(json[0]["against"][0]["median"], 6);
  EXPECT_EQ(json[0]["against"][0]["ratio"], 1.5);
  const Measurement skewed{"frame", "", 0, {1, 4, 8}, {{"peer", "", {9, 6, 2}, {9, 1.5, .25}}}, -1};
  EXPECT_EQ(report_json(of_one_row(skewed))["rows"][0]["against"][0]["ratio"], 1.5);
}

TEST(BenchTable, ARateIsShownWhereATurnIsManyRays) {
  const Measurement row{"rays", "", 2e6, {400, 500, 1000}, {}, -1};
  const auto json = report_json(of_one_row(row))["rows"];
  EXPECT_EQ(json[0]["median"], 4);  // 2 million in 0.5 s
  EXPECT_EQ(json[0]["p99"], 2);     // 2 million in 1 s
  EXPECT_EQ(json[0]["unit"], "M rays/s");
}

TEST(BenchTable, EveryComparisonStandsBelowItsWork) {
  const Measurement row{"frame", "24 % of the pixels hit", 0, {2}, {{"peer", "", {5}, {2.5}}}, -1};
  const std::string text = report_text(of_one_row(row));
  EXPECT_NE(text.find("bone"), std::string::npos);
  EXPECT_LT(text.find("frame"), text.find("  peer"));
  EXPECT_NE(text.find("2.50 x"), std::string::npos);
  EXPECT_NE(text.find("24 % of the pixels hit"), std::string::npos);
}

}  // namespace
}  // namespace isolux
