// SPDX-License-Identifier: MIT
// `glint doctor` and `glint track --realtime` on this very computer, whatever it has.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <fstream>
#include <string>

#include <nlohmann/json.hpp>

#include "tests/support/temp_dir.hpp"
#include "tests/system/run_glint.hpp"

namespace glint::test {
namespace {

using ::testing::HasSubstr;

std::size_t count_of(const nlohmann::json& findings, const char* key, const std::string& value) {
  return static_cast<std::size_t>(
      std::count_if(findings.begin(), findings.end(),
                    [&](const nlohmann::json& finding) { return finding.at(key) == value; }));
}

TEST(Doctor, ChecksEverythingAndItsExitCodeSaysWhetherCamerasCanWork) {
  const Outcome outcome = run_glint({"doctor", "--json"});
  const nlohmann::json json = nlohmann::json::parse(outcome.out, nullptr, false);
  ASSERT_TRUE(json.contains("findings")) << outcome.out << outcome.err;
  const nlohmann::json& findings = json["findings"];
  for (const char* check :
       {"cameras", "rig", "vulkan", "priority", "memory lock", "governor", "cpus", "clock"})
    EXPECT_GE(count_of(findings, "check", check), 1u) << check;
  const std::size_t problems = count_of(findings, "verdict", "problem");
  EXPECT_EQ(json["problems"], problems);
  EXPECT_EQ(outcome.exit_code, problems > 0 ? 1 : 0);
  for (const nlohmann::json& finding : findings) {
    EXPECT_NE(finding.at("text"), "");
    if (finding.at("verdict") != "ok") {
      EXPECT_NE(finding.at("advice"), "") << finding;
    }
  }
}

TEST(Doctor, SaysTheSameInWords) {
  const Outcome outcome = run_glint({"doctor"});
  EXPECT_THAT(outcome.out, HasSubstr("cameras"));
  EXPECT_THAT(outcome.out, HasSubstr("vulkan"));
  EXPECT_EQ(outcome.exit_code == 1, outcome.err.find("live capture") != std::string::npos) << outcome.err;
}

TEST(Doctor, LooksForTheCamerasOfTheRig) {
  const Outcome outcome = run_glint({"doctor", "--rig", "docs/rig.example.toml"});
  EXPECT_EQ(outcome.exit_code, 1);
  for (const char* camera : {"north-east", "north-west", "south-west", "south-east"})
    EXPECT_THAT(outcome.out, HasSubstr(std::string("camera ") + camera + ": "));
}

TEST(Doctor, NamesARigFileThatIsNotThere) {
  const Outcome outcome = run_glint({"doctor", "--rig", "no-such.toml"});
  EXPECT_EQ(outcome.exit_code, 1);
  EXPECT_THAT(outcome.err, HasSubstr("no-such.toml"));
}

TEST(RealTimeRun, SaysWhatItGot) {
  const TempDir folder;
  const std::string summary = (folder.path() / "summary.json").string();
  const Outcome outcome = run_glint({"track", "sim", "--device", "cpu", "--ticks", "30", "--realtime", "auto",
                                     "--pin", "0", "--summary", summary});
  ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
  std::ifstream file(summary);
  const nlohmann::json json = nlohmann::json::parse(file, nullptr, false);
  ASSERT_TRUE(json.contains("real_time"));
  const nlohmann::json& real_time = json["real_time"];
  EXPECT_EQ(real_time["mode"], "auto");
  EXPECT_EQ(real_time["cpus"], nlohmann::json::array({0}));
  std::size_t started = 0, fifo = 0;
  for (const nlohmann::json& threads : real_time["threads"]) {
    EXPECT_EQ(threads["pinned"], threads["started"]);
    started += threads["started"].get<std::size_t>();
    fifo += threads["fifo"].get<std::size_t>();
  }
  EXPECT_EQ(started, 2u) << "capture and tracking";
  const bool all = fifo == started && real_time["memory_locked"] == true;
  EXPECT_EQ(all, real_time["refusal"] == "") << real_time;
  EXPECT_EQ(all, outcome.err.find("limits.d") == std::string::npos) << outcome.err;
  EXPECT_THAT(outcome.err, HasSubstr("real time  "));
}

TEST(RealTimeRun, WrongArgumentsAreNamed) {
  const auto refused = [](std::vector<std::string> more, const std::string& part) {
    std::vector<std::string> arguments{"track", "sim", "--ticks", "1"};
    arguments.insert(arguments.end(), more.begin(), more.end());
    const Outcome outcome = run_glint(arguments);
    EXPECT_EQ(outcome.exit_code, 2);
    EXPECT_THAT(outcome.err, HasSubstr(part));
  };
  refused({"--pin", "8191"}, "CPU 8191 is not there");
  refused({"--pin", "a"}, "--pin a: must be a list");
  refused({"--realtime", "maybe"}, "--realtime maybe");
  refused({"--pin", "0", "--pace", "fast"}, "only for live sources");
  refused({"--realtime", "require", "--pace", "fast"}, "only for live sources");
}

}  // namespace
}  // namespace glint::test
