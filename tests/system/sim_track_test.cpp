// SPDX-License-Identifier: MIT
// The main job, end to end: the simulated rig's pictures through detector, correspondence and tracker,
// against the truth.
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include <algorithm>
#include <fstream>
#include <map>
#include <set>
#include <sstream>
#include <string>

#include "gpu/detector.hpp"
#include "tests/support/temp_dir.hpp"
#include "tests/system/run_glint.hpp"

namespace glint::test {
namespace {

nlohmann::json track_sim(std::vector<std::string> more) {
  const TempDir folder;
  const std::string summary = (folder.path() / "summary.json").string();
  std::vector<std::string> arguments{"track", "sim", "--pace", "fast", "--quiet", "--summary", summary};
  arguments.insert(arguments.end(), more.begin(), more.end());
  const Outcome outcome = run_glint(arguments);
  EXPECT_EQ(outcome.exit_code, 0) << outcome.err;
  std::ifstream file(summary);
  return nlohmann::json::parse(file, nullptr, false);
}

std::vector<std::string> devices() {
  std::vector<std::string> names{"cpu"};
  for (const gpu::DeviceInfo& device : gpu::list_devices()) {
    if (device.usable) names.push_back(std::to_string(device.index));
  }
  return names;
}

class SimulatedRig : public ::testing::TestWithParam<std::string> {};

TEST_P(SimulatedRig, IsTrackedToTheCramerRaoBoundOfOneExposure) {
  const nlohmann::json s = track_sim({"--ticks", "450", "--device", GetParam()});
  ASSERT_TRUE(s.contains("score"));
  EXPECT_EQ(s["ticks"], 450);
  EXPECT_GE(s["score"]["recall"].get<double>(), 0.999);
  EXPECT_LE(s["score"]["ghost_rate"].get<double>(), 1e-4);
  EXPECT_LE(s["score"]["rms_m"].get<double>(), 0.08e-3);
  // A track knows the exposures before, too, so it may come a little below what one exposure allows.
  EXPECT_LE(s["score"]["ratio"].get<double>(), 1.5);
  EXPECT_GE(s["score"]["ratio"].get<double>(), 0.7) << "better than smoothing explains: the score is wrong";
}

INSTANTIATE_TEST_SUITE_P(Devices, SimulatedRig, ::testing::ValuesIn(devices()),
                         [](const auto& tested) { return "device_" + tested.param; });

TEST(SimulatedRigWithFaults, LosesFramesButNotMarkers) {
  const nlohmann::json s = track_sim({"--ticks", "300", "--device", "cpu", "--drop-rate", "0.05",
                                      "--late-rate", "0.02", "--duplicate-rate", "0.02"});
  EXPECT_GT(s["frames"]["missing"].get<int>(), 20);
  EXPECT_GT(s["frames"]["late"].get<int>(), 5);
  EXPECT_GT(s["frames"]["duplicated"].get<int>(), 5);
  EXPECT_GE(s["score"]["recall"].get<double>(), 0.995);
  EXPECT_LE(s["score"]["ghost_rate"].get<double>(), 1e-3);
}

TEST(SimulatedRigWithOccluders, KeepsMarkersThatTwoCamerasSee) {
  const nlohmann::json s = track_sim({"--ticks", "300", "--device", "cpu", "--occluders", "3"});
  EXPECT_GE(s["score"]["recall"].get<double>(), 0.99);
  EXPECT_LE(s["score"]["ghost_rate"].get<double>(), 1e-3);
}

TEST(SimulatedRigBumped, ShowsInTheErrorAndInTheCamerasHealth) {
  const nlohmann::json good = track_sim({"--ticks", "120", "--device", "cpu"});
  const nlohmann::json bumped = track_sim({"--ticks", "120", "--device", "cpu", "--bump", "1:0:0.05"});
  // No more than that, since most of its views are found to disagree and are left out.
  EXPECT_GT(bumped["score"]["rms_m"].get<double>(), 1.2 * good["score"]["rms_m"].get<double>());
  // And whose fault it is: what the others measure together, the bumped one hardly ever confirms.
  for (std::size_t camera = 0; camera < 4; ++camera) {
    const nlohmann::json& health = bumped["health"][camera];
    const double compared = health["compared"].get<double>(), agreed = health["agreed"].get<double>();
    ASSERT_GT(compared, 100.0);
    if (camera == 0) {
      EXPECT_LE(agreed, 0.02 * compared);
      EXPECT_GT(health["residual_px"].get<double>(), 5.0 * health["expected_px"].get<double>());
    } else {
      EXPECT_GE(agreed, 0.98 * compared);
    }
  }
}

TEST(CrowdedMarkers, NeverChangeIdsSilently) {
  const TempDir folder;
  const std::string points = (folder.path() / "points.jsonl").string();
  const nlohmann::json s =
      track_sim({"--ticks", "200", "--device", "cpu", "--motion", "tumbling", "--bodies", "8", "--markers",
                 "40", "--missing-rate", "0.3", "--calibration-error", "1", "--output", "jsonl:" + points});
  std::map<std::string, int> counts{{"kept", 0}, {"swapped", 0}, {"unresolved", 0}};
  std::map<std::string, int> kinds;
  std::map<int, std::set<int>> in_doubt_with;
  std::set<int> gone;
  std::ifstream file(points);
  for (std::string line; std::getline(file, line);) {
    const nlohmann::json tick = nlohmann::json::parse(line);
    std::map<int, int> renamed;
    for (const nlohmann::json& event : tick.value("identity", nlohmann::json::array())) {
      const std::string kind = event["kind"];
      const int a = event["a"], b = event["b"];
      ++counts[kind];
      if (kind == "ambiguous") {
        EXPECT_EQ(in_doubt_with[a].count(b), 0u) << line;
        in_doubt_with[a].insert(b);
        in_doubt_with[b].insert(a);
        continue;
      }
      EXPECT_EQ(in_doubt_with[a].count(b), 1u) << line;
      in_doubt_with[a].erase(b);
      in_doubt_with[b].erase(a);
      if (kind != "unresolved") continue;
      gone.insert({a, b});
      // Other doubts go on under the new ids, but for those that end with this exposure.
      for (const auto& [old_id, now] : {std::pair(a, event["new_a"]), std::pair(b, event["new_b"])})
        if (!now.is_null()) renamed[old_id] = now.get<int>();
    }
    for (const auto& [old_id, now] : renamed) {
      for (const int other : in_doubt_with[old_id]) {
        in_doubt_with[other].erase(old_id);
        in_doubt_with[other].insert(now);
      }
      in_doubt_with[now].merge(in_doubt_with[old_id]);
      in_doubt_with.erase(old_id);
    }
    for (const nlohmann::json& point : tick["points"]) {
      const int id = point["id"];
      ++kinds[point["kind"]];
      EXPECT_EQ(gone.count(id), 0u) << "an id that may be wrong is used again: " << line;
      if (!in_doubt_with[id].empty()) {
        ASSERT_FALSE(point["ambiguous"].is_null()) << line;
        EXPECT_EQ(in_doubt_with[id].count(point["ambiguous"].get<int>()), 1u) << line;
      } else {
        EXPECT_TRUE(point["ambiguous"].is_null()) << line;
      }
      EXPECT_EQ(point["kind"] == "measured", point["age"] == 0) << line;
      EXPECT_GT(point["sd_m"].get<double>(), 0.0) << line;
    }
  }
  EXPECT_GT(counts["ambiguous"], 5) << "nothing was in doubt: the test shows nothing";
  EXPECT_EQ(s["identity"]["ambiguous_pairs"], counts["ambiguous"]);
  for (const char* const end : {"kept", "swapped", "unresolved"}) EXPECT_EQ(s["identity"][end], counts[end]);
  EXPECT_EQ(s["identity"]["points"]["measured"], kinds["measured"]);
  EXPECT_EQ(s["identity"]["points"]["single_view"], kinds["single-view"]);
  EXPECT_EQ(s["identity"]["points"]["predicted"], kinds["predicted"]);
}

TEST(Recording, OfTheSimulatedRigTracksLikeTheLiveOne) {
  const TempDir folder;
  const std::string take = (folder.path() / "take").string();
  ASSERT_EQ(run_glint({"sim", "--out", take, "--seconds", "0.5"}).exit_code, 0);
  const std::string csv = (folder.path() / "points.csv").string();
  const Outcome outcome = run_glint(
      {"track", "images:" + take, "--rig", take + "/calibration.toml", "--output", "csv:" + csv, "--quiet"});
  EXPECT_EQ(outcome.exit_code, 0) << outcome.err;
  std::ifstream file(csv);
  std::string header, line;
  std::getline(file, header);
  EXPECT_EQ(header, "tick,time_ns,id,x_m,y_m,z_m,residual_px,cameras,aligned,kind,age,ambiguous,sd_m");
  int rows = 0;
  while (std::getline(file, line)) ++rows;
  EXPECT_GE(rows, 45 * 20 * 95 / 100);
}

TEST(CodedPulses, FindASlippedCameraAndCorrectIt) {
  const TempDir folder;
  const std::string csv = (folder.path() / "points.csv").string();
  const nlohmann::json s =
      track_sim({"--ticks", "700", "--device", "cpu", "--code-seed", "7", "--code-first", "12345", "--slip",
                 "2:450:3", "--drop-rate", "0.02", "--output", "csv:" + csv});
  EXPECT_EQ(s["alignment"]["phase"], 12345 % 7680);
  EXPECT_GT(s["alignment"]["dark_pulses"].get<int>(), 10);
  for (const nlohmann::json& camera : s["alignment"]["cameras"]) {
    const int slips = camera["name"] == "cam2" ? 1 : 0;
    EXPECT_EQ(camera["slips_found"], slips);
    EXPECT_EQ(camera["slips_corrected"], slips);
    EXPECT_LT(camera["longest_unproven_s"].get<double>(), 4.0);
  }
  EXPECT_GE(s["score"]["recall"].get<double>(), 0.995);
  std::ifstream file(csv);
  std::string line;
  std::getline(file, line);
  int aligned = 0, rows = 0;
  for (; std::getline(file, line); ++rows) {
    std::istringstream fields(line);
    for (int k = 0; k < 9; ++k) std::getline(fields, line, ',');
    aligned += line == "1" ? 1 : 0;
  }
  EXPECT_GT(aligned, rows / 2);
  EXPECT_LT(aligned, rows * 9 / 10);
}

TEST(CodedPulses, ThatAreNotThereAreMissed) {
  const TempDir folder;
  const std::string rig = (folder.path() / "rig.toml").string();
  ASSERT_EQ(run_glint({"sim", "--rig-out", (folder.path() / "cal.toml").string()}).exit_code, 0);
  std::ofstream(rig) << "format = 1\nkind = \"rig\"\n[rig]\nname = \"r\"\nrate_hz = 90\n"
                        "calibration = \"cal.toml\"\n[sync]\ncode_seed = 5\ncode_group = 20\n";
  const Outcome outcome = run_glint({"track", "sim", "--pace", "fast", "--device", "cpu", "--ticks", "700",
                                     "--rig", rig, "--output", "jsonl:-"});
  EXPECT_EQ(outcome.exit_code, 0) << outcome.err;
  EXPECT_NE(outcome.err.find("check sync.code_seed"), std::string::npos) << outcome.err;
  EXPECT_EQ(outcome.out.find("\"aligned\":true"), std::string::npos);
  EXPECT_NE(outcome.out.find("\"aligned\":false"), std::string::npos);
}

TEST(CtrlC, EndsCleanlyWithTheSummary) {
  const Outcome outcome = run_glint({"track", "sim", "--device", "cpu"},
                                    {.environment = {}, .interrupt_after_s = 3.0, .standard_output = {}});
  EXPECT_EQ(outcome.exit_code, 0) << outcome.err;
  EXPECT_NE(outcome.err.find("missed ticks"), std::string::npos) << outcome.err;
}

TEST(JsonLines, OnStandardOutputAreAloneThere) {
  const Outcome outcome =
      run_glint({"track", "sim", "--device", "cpu", "--pace", "fast", "--ticks", "5", "--output", "jsonl:-"});
  EXPECT_EQ(outcome.exit_code, 0) << outcome.err;
  std::istringstream lines(outcome.out);
  std::string line;
  int ticks = 0;
  while (std::getline(lines, line)) {
    EXPECT_TRUE(nlohmann::json::accept(line)) << line;
    ++ticks;
  }
  EXPECT_EQ(ticks, 5);
}

}  // namespace
}  // namespace glint::test
