// SPDX-License-Identifier: MIT
// Short scenes of the identity benchmark, with limits that must not be crossed, and its program as others use
// it.
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <string>
#include <vector>

#include <nlohmann/json.hpp>

#include "tests/support/temp_dir.hpp"
#include "tests/system/run_glint.hpp"

namespace glint::test {
namespace {

namespace fs = std::filesystem;

Outcome run_identity(const std::vector<std::string>& arguments) {
  RunOptions options;
  options.program = GLINT_IDENTITY;
  return run_glint(arguments, options);
}

struct Limit {
  const char* scene;
  const char* ticks;
  double recall, ghosts_per_tick, silent_swaps, worst_m;
};

void PrintTo(const Limit& limit, std::ostream* out) { *out << limit.scene; }

class IdentityLimits : public testing::TestWithParam<Limit> {};

TEST_P(IdentityLimits, AreKept) {
  const Limit& limit = GetParam();
  const TempDir folder;
  const std::string json = (folder.path() / "runs.json").string();
  const Outcome outcome =
      run_identity({"run", limit.scene, "--seeds", "1", "--ticks", limit.ticks, "--json", json});
  ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
  EXPECT_NE(outcome.out.find("Shortened runs: no result"), std::string::npos);
  std::ifstream file(json);
  const nlohmann::json runs = nlohmann::json::parse(file);
  ASSERT_EQ(runs.size(), 1u);
  EXPECT_EQ(std::to_string(runs[0]["ticks"].get<int>()), limit.ticks);
  const nlohmann::json& glint = runs[0]["glint"];
  EXPECT_GE(glint["recall"].get<double>(), limit.recall);
  EXPECT_LE(glint["ghosts_per_tick"].get<double>(), limit.ghosts_per_tick);
  EXPECT_LE(glint["silent_swaps"].get<double>(), limit.silent_swaps);
  EXPECT_LE(glint["worst"].get<double>(), limit.worst_m);
  EXPECT_EQ(glint["covariance_faults"], 0);
  EXPECT_GT(glint["nees_samples"].get<int>(), 100);
  EXPECT_GE(runs[0]["plain"]["recall"].get<double>(), 0.5);  // or the scene is not what it should be
  const std::string name = limit.scene;
  const bool of_bodies = name == "bodies-8" || name == "tumbling-3" || name == "crossing-2";
  ASSERT_EQ(runs[0].contains("poses"), of_bodies);
  EXPECT_EQ(outcome.out.find("glint with the bodies known") != std::string::npos, of_bodies);
  if (!of_bodies) return;
  EXPECT_GE(runs[0]["bodies_known"]["recall"].get<double>(), limit.recall);
  EXPECT_GE(runs[0]["poses"]["recall"].get<double>(), 0.95);
  EXPECT_EQ(runs[0]["poses"]["silent_swaps"], 0);
}

INSTANTIATE_TEST_SUITE_P(Scenes, IdentityLimits,
                         testing::Values(Limit{"rod", "300", 0.995, 0.0, 0, 1e-3},
                                         Limit{"markers-50", "150", 0.999, 0.0, 0, 2e-3},
                                         Limit{"missing-20", "200", 0.97, 0.02, 0, 10e-3},
                                         Limit{"bodies-8", "150", 0.98, 0.15, 4, 10e-3},
                                         Limit{"tumbling-3", "200", 0.99, 0.01, 0, 10e-3},
                                         Limit{"crossing-2", "200", 0.99, 0.0, 0, 2e-3},
                                         Limit{"pairs", "150", 0.98, 0.0, 0, 3e-3},
                                         Limit{"two-cameras-50", "150", 0.99, 0.02, 0, 10e-3},
                                         Limit{"thrown", "200", 0.99, 0.0, 0, 1e-3}));

class GeneratedScene : public testing::Test {
 protected:
  GeneratedScene() : scene_((folder_.path() / "scene").string()) {
    const Outcome made = run_identity({"generate", "markers-20", scene_, "--seed", "2", "--ticks", "60"});
    EXPECT_EQ(made.exit_code, 0) << made.err;
  }
  Outcome score(const std::string& points) const {
    const fs::path file = folder_.path() / "points.csv";
    std::ofstream(file) << points;
    return run_identity({"score", scene_, file.string()});
  }
  /// The file is refused, in that line, in such words.
  void expect_refused(const std::string& points, int line, const std::string& words) const {
    const Outcome outcome = score(points);
    EXPECT_EQ(outcome.exit_code, 1) << points;
    EXPECT_NE(outcome.err.find("points.csv:" + std::to_string(line) + ":"), std::string::npos) << outcome.err;
    EXPECT_NE(outcome.err.find(words), std::string::npos) << outcome.err;
  }

  TempDir folder_;
  std::string scene_;
};

// What was written is what glint reads: tracked from the files alone, it scores as from the frames.
TEST_F(GeneratedScene, IsTrackedFromItsFilesAndScored) {
  const std::string points = (folder_.path() / "glint.csv").string();
  const Outcome tracked =
      run_glint({"track", "blobs:" + scene_ + "/blobs", "--rig", scene_ + "/calibration.toml", "--rate", "90",
                 "--pace", "fast", "--output", "csv:" + points});
  ASSERT_EQ(tracked.exit_code, 0) << tracked.err;
  const Outcome scored = run_identity({"score", scene_, points});
  ASSERT_EQ(scored.exit_code, 0) << scored.err;
  EXPECT_NE(scored.err.find("scene markers-20, seed 2, 60 frames"), std::string::npos) << scored.err;
  const auto figure = [&](const std::string& title) {
    const std::size_t line = scored.out.find(title + " ");
    return line == std::string::npos ? -1.0 : std::stod(scored.out.substr(line + title.size()));
  };
  EXPECT_GE(figure("recall"), 0.98) << scored.out;
  EXPECT_EQ(figure("ghosts"), 0.0) << scored.out;
  EXPECT_EQ(figure("mixed points"), 0.0) << scored.out;
  EXPECT_LE(figure("RMS"), 1.0) << scored.out;  // mm
  EXPECT_GT(figure("RMS"), 0.0) << scored.out;
}

TEST_F(GeneratedScene, ErrorsNameTheLine) {
  const std::string head = "tick,id,x_m,y_m,z_m,kind,ambiguous,sd_m\n";
  EXPECT_EQ(score(head + "3,1,0,0,1,measured,0,0.001\n3,2,0,0,1,predicted,1,0\n").exit_code, 0);
  EXPECT_EQ(score(head + "3,1,0,0,1,single-view,4000000000,0\n3,2,0,0,1,measured,,0\n").exit_code, 0);
  expect_refused("tick,id,x_m,y_m\n", 1, "\"z_m\" is missing");
  expect_refused(head + "3,1,0,0,1,guessed,0,0\n", 2, "not measured, single-view or predicted");
  expect_refused(head + "3,1,0,0,1,measured,yes,0\n", 2, "ambiguous");
  expect_refused(head + "3,1,0,0,1,measured,0,0\n2,1,0,0,1,measured,0,0\n", 3, "goes back");
  expect_refused(head + "60,1,0,0,1,measured,0,0\n", 2, "ends with tick 59");
  expect_refused(head + "3,1,0,0\n", 2, "4 fields");
  expect_refused("tick,id,x_m,y_m,z_m,cameras\n1,1,0,0,1,1+5\n", 2, "from 1 to 4");
  expect_refused("tick,id,x_m,y_m,z_m,xx_m2\n1,1,0,0,1,1\n", 1, "all of xx_m2");
}

TEST_F(GeneratedScene, ExitCodesAndRefusals) {
  EXPECT_EQ(run_identity({"list"}).exit_code, 0);
  const Outcome unknown = run_identity({"run", "no-such-scene"});
  EXPECT_EQ(unknown.exit_code, 2);
  EXPECT_NE(unknown.err.find("markers-20"), std::string::npos) << unknown.err;
  EXPECT_EQ(run_identity({"frobnicate"}).exit_code, 2);
  EXPECT_EQ(run_identity({"generate", "markers-20", scene_}).exit_code, 1);  // not empty
  EXPECT_EQ(run_identity({"score", scene_, "/no/such/file.csv"}).exit_code, 1);
  std::ofstream(fs::path(scene_) / "scene.json") << R"({"scene": "markers-20", "seed": 2, "ticks": 60})";
  const Outcome changed = score("tick,id,x_m,y_m,z_m\n");
  EXPECT_EQ(changed.exit_code, 1);
  EXPECT_NE(changed.err.find("other settings"), std::string::npos) << changed.err;
}

}  // namespace
}  // namespace glint::test
