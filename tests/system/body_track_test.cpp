// SPDX-License-Identifier: MIT
// Rigid bodies through the whole program: the simulated rig's own, those of a file, and what is refused.
#include <gtest/gtest.h>

#include <cmath>
#include <fstream>
#include <sstream>
#include <string>
#include <vector>

#include <nlohmann/json.hpp>

#include "tests/support/temp_dir.hpp"
#include "tests/system/run_glint.hpp"

namespace glint::test {
namespace {

std::vector<std::string> lines_of(const std::string& path) {
  std::ifstream file(path);
  std::vector<std::string> lines;
  for (std::string line; std::getline(file, line);) lines.push_back(line);
  return lines;
}

TEST(TumblingBodies, AreMeasuredByNameWithPoses) {
  const TempDir folder;
  const std::string csv = (folder.path() / "poses.csv").string(),
                    jsonl = (folder.path() / "points.jsonl").string(),
                    summary = (folder.path() / "summary.json").string();
  const Outcome outcome =
      run_glint({"track", "sim", "--motion", "tumbling", "--bodies", "2", "--ticks", "180", "--pace", "fast",
                 "--device", "cpu", "--poses", csv, "--output", "jsonl:" + jsonl, "--summary", summary});
  ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
  EXPECT_NE(outcome.err.find("body body1 found"), std::string::npos) << outcome.err;
  EXPECT_NE(outcome.err.find("RMS error of poses"), std::string::npos) << outcome.err;

  std::ifstream file(summary);
  const nlohmann::json bodies = nlohmann::json::parse(file)["bodies"];
  ASSERT_EQ(bodies["bodies"].size(), 2u);
  EXPECT_EQ(bodies["lost"], 0);
  const nlohmann::json& score = bodies["score"];
  EXPECT_GE(score["recall"].get<double>(), 0.97);
  EXPECT_EQ(score["astray"], 0);
  EXPECT_EQ(score["silent_swaps"], 0);
  EXPECT_LE(score["rms_m"].get<double>(), 0.1e-3);
  EXPECT_LE(score["rms_rad"].get<double>(), 2e-3);

  const std::vector<std::string> rows = lines_of(csv);
  EXPECT_EQ(rows.at(0), "tick,time_ns,body,x_m,y_m,z_m,qx,qy,qz,qw,kind,age,markers,ambiguous,sd_m,sd_rad");
  EXPECT_GE(rows.size() - 1, 340u);
  std::size_t in_json = 0;
  for (const std::string& line : lines_of(jsonl)) {
    const nlohmann::json tick = nlohmann::json::parse(line);
    for (const nlohmann::json& body : tick.at("bodies")) {
      ++in_json;
      const double norm = std::hypot(std::hypot(body["qx"].get<double>(), body["qy"].get<double>()),
                                     std::hypot(body["qz"].get<double>(), body["qw"].get<double>()));
      EXPECT_NEAR(norm, 1.0, 1e-6);
      EXPECT_TRUE(body["name"] == "body1" || body["name"] == "body2") << line;
      EXPECT_GT(body["sd_m"].get<double>(), 0.0);
    }
  }
  EXPECT_EQ(in_json, rows.size() - 1);
}

TEST(LearntBodies, AreFoundAgainInAnotherRun) {
  const TempDir folder;
  const std::string walk = (folder.path() / "walk.csv").string(),
                    bodies = (folder.path() / "bodies.toml").string(),
                    csv = (folder.path() / "poses.csv").string();
  const std::vector<std::string> sim{"track",   "sim",    "--motion", "tumbling", "--bodies",
                                     "2",       "--pace", "fast",     "--device", "cpu",
                                     "--ticks", "180",    "--quiet"};
  std::vector<std::string> first = sim, again = sim;
  first.insert(first.end(), {"--output", "csv:" + walk});
  Outcome outcome = run_glint(first);
  ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
  outcome = run_glint({"body", "learn", walk, "--names", "drone,cart", "--out", bodies});
  ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
  again.insert(again.end(), {"--body", bodies, "--poses", csv});
  outcome = run_glint(again);
  ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
  std::size_t drone = 0, cart = 0;
  for (const std::string& line : lines_of(csv)) {
    drone += line.find(",drone,") != std::string::npos ? 1u : 0u;
    cart += line.find(",cart,") != std::string::npos ? 1u : 0u;
  }
  EXPECT_GT(drone, 160u);
  EXPECT_GT(cart, 160u);
}

TEST(PosesOfNothing, AreRefused) {
  const TempDir folder;
  const Outcome outcome = run_glint({"track", "sim", "--ticks", "5", "--pace", "fast", "--device", "cpu",
                                     "--poses", (folder.path() / "p.csv").string()});
  EXPECT_EQ(outcome.exit_code, 2);
  EXPECT_NE(outcome.err.find("--body FILE"), std::string::npos) << outcome.err;
}

TEST(PosesAndPoints, DoNotMixOnStandardOutput) {
  const Outcome outcome = run_glint(
      {"track", "sim", "--motion", "tumbling", "--ticks", "5", "--output", "csv:-", "--poses", "-"});
  EXPECT_EQ(outcome.exit_code, 2);
  EXPECT_TRUE(outcome.out.empty()) << outcome.out;
}

}  // namespace
}  // namespace glint::test
