// SPDX-License-Identifier: MIT
// One row per device, scene and quantity, with as many fields in each.
#include "host/bench/report_csv.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <sstream>
#include <vector>

#include "tests/unit/bench/sample_results.hpp"

namespace glint::bench {
namespace {

using ::testing::HasSubstr;
using ::testing::StartsWith;

std::vector<std::string> lines_of(const std::string& text) {
  std::vector<std::string> lines;
  std::istringstream stream(text);
  for (std::string line; std::getline(stream, line);) lines.push_back(line);
  return lines;
}

std::size_t fields_of(const std::string& line) {
  std::size_t fields = 1;
  bool quoted = false;
  for (const char c : line) {
    if (c == '"') quoted = !quoted;
    if (c == ',' && !quoted) ++fields;
  }
  return fields;
}

TEST(ReportCsv, HasOneLinePerQuantity) {
  const std::vector<std::string> lines = lines_of(to_csv(test::sample_results()));
  // 3 rows with 6 series and 3 single figures, 3 rows without figures, 4 headlines
  ASSERT_EQ(lines.size(), 1u + 3u * 9u + 3u + 4u);
  EXPECT_EQ(
      lines[0],
      "device,type,software,cameras,width_px,height_px,blobs,noise_grey,outcome,quantity,unit,value,count,"
      "p50,p90,p99,max,problem");
  for (const std::string& line : lines) EXPECT_EQ(fields_of(line), fields_of(lines[0])) << line;
  EXPECT_EQ(lines[1], "llvmpipe,software,1,4,1280,800,0,1.2,ok,wall,s,,101,0.0005,0.00054,0.000549,0.00055,");
  EXPECT_EQ(lines[7], "llvmpipe,software,1,4,1280,800,0,1.2,ok,throughput,ticks/s,2500,,,,,,");
}

TEST(ReportCsv, GivesAWrongDeviceNoFigures) {
  for (const std::string& line : lines_of(to_csv(test::sample_results()))) {
    if (!line.starts_with("\"Wrong GPU, fast\"")) continue;
    EXPECT_THAT(line, HasSubstr(",FAIL,"));
    EXPECT_THAT(line, HasSubstr(",,,,,,,\"tick 0"));
  }
}

TEST(ReportCsv, AddsColumnsForAComparison) {
  const Baseline before{"old.json", test::sample_results()};
  const std::vector<std::string> lines = lines_of(to_csv(test::sample_results(), &before));
  EXPECT_THAT(lines[0], HasSubstr(",old_p50,ratio,verdict,problem"));
  for (const std::string& line : lines) EXPECT_EQ(fields_of(line), fields_of(lines[0])) << line;
  EXPECT_THAT(lines[1], HasSubstr(",0.0005,1,same within noise,"));
}

}  // namespace
}  // namespace glint::bench
