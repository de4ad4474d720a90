// SPDX-License-Identifier: MIT
// `glint bench` as a person runs it, shortly, on every device here; and with shaders that are wrong.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include <filesystem>
#include <fstream>
#include <iostream>
#include <regex>
#include <sstream>

#include "gpu/detector.hpp"
#include "tests/support/temp_dir.hpp"
#include "tests/system/run_glint.hpp"

namespace glint::test {
namespace {

using ::testing::HasSubstr;
using ::testing::Not;
using Json = nlohmann::json;

using Arguments = std::vector<std::string>;

Outcome bench(const Arguments& more, const RunOptions& options = {}) {
  Arguments arguments{"bench",     "-n", "5",       "--max-time", "0.2",     "--warmup", "2",
                      "--cameras", "1",  "--sizes", "320x240",    "--blobs", "0,5",      "--no-headline",
                      "--quiet"};
  arguments.insert(arguments.end(), more.begin(), more.end());
  return run_glint(arguments, options);
}

std::string text_of(const std::filesystem::path& path) {
  std::ifstream file(path, std::ios::binary);
  std::ostringstream text;
  text << file.rdbuf();
  return text.str();
}

std::vector<std::string> vulkan_devices() {
  std::vector<std::string> indices;
  for (const gpu::DeviceInfo& device : gpu::list_devices()) {
    if (device.usable) indices.push_back(std::to_string(device.index));
  }
  return indices;
}

class BenchOn : public ::testing::TestWithParam<std::string> {};

TEST_P(BenchOn, GivesFiguresOfARightDevice) {
  const Outcome o = bench({"--device", GetParam(), "-o", "json"});
  ASSERT_EQ(o.exit_code, 0) << o.err;
  EXPECT_EQ(o.err, "");
  const Json json = Json::parse(o.out);
  EXPECT_EQ(json["schema"]["name"], "glint-bench");
  EXPECT_EQ(json["schema"]["version"], 1);
  EXPECT_FALSE(json["glint_version"].get<std::string>().empty());
  EXPECT_TRUE(std::regex_match(json["shader_hash"].get<std::string>(), std::regex("[0-9a-f]{16}")));
  EXPECT_THAT(json["machine"]["kernel"].get<std::string>(), HasSubstr("Linux"));
  EXPECT_GE(json["machine"]["logical_cores"].get<int>(), 1);
  ASSERT_EQ(json["devices"].size(), 1u);
  const Json& device = json["devices"][0];
  EXPECT_EQ(device["vulkan"].is_null(), GetParam() == "cpu");
  if (GetParam() != "cpu") {
    EXPECT_EQ(device["software"], device["vulkan"]["device_type"] == "software");
    EXPECT_FALSE(device["vulkan"]["heaps"].empty());
    EXPECT_FALSE(device["vulkan"]["device_uuid"].get<std::string>().empty());
  }
  ASSERT_EQ(device["rows"].size(), 2u);
  for (const Json& row : device["rows"]) {
    EXPECT_EQ(row["outcome"], "ok");
    EXPECT_EQ(row["blobs_per_tick"], row["scene"]["blobs"]);
    const std::size_t ticks = row["wall"]["count"];
    EXPECT_GE(ticks, 1u);
    EXPECT_LE(ticks, 5u);
    for (const Json& series : {row["wall"], row["cpu"], row["interval"], row["paced"]["latency"]}) {
      EXPECT_EQ(series["samples_s"].size(), series["count"].get<std::size_t>());
      EXPECT_GT(series["p50_s"].get<double>(), 0.0);
      EXPECT_LE(series["p50_s"].get<double>(), series["max_s"].get<double>());
      EXPECT_LT(series["max_s"].get<double>(), 60.0);
    }
    ASSERT_FALSE(row["stages"].empty());
    for (const Json& stage : row["stages"]) {
      EXPECT_LE(stage["time"]["p50_s"].get<double>(), row["wall"]["max_s"].get<double>()) << stage["name"];
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Cpu, BenchOn, ::testing::Values("cpu"),
                         [](const auto& tested) { return "device_" + tested.param; });
INSTANTIATE_TEST_SUITE_P(Vulkan, BenchOn, ::testing::ValuesIn(vulkan_devices()),
                         [](const auto& tested) { return "device_" + tested.param; });
GTEST_ALLOW_UNINSTANTIATED_PARAMETERIZED_TEST(BenchOn);

TEST(Bench, RunsOnEverythingWithoutBeingTold) {
  if (vulkan_devices().empty()) std::cout << "SKIPPED: no Vulkan device; only the CPU is tried\n";
  const Outcome o = bench({});
  ASSERT_EQ(o.exit_code, 0) << o.err;
  EXPECT_THAT(o.out, HasSubstr("| cpu ("));
  for (const gpu::DeviceInfo& device : gpu::list_devices()) {
    if (!device.usable) continue;
    EXPECT_THAT(o.out, HasSubstr("| " + device.name + (device.software ? " (software, no GPU)" : "")));
  }
  EXPECT_THAT(o.out, HasSubstr("| 1 x 320x240, 5 blobs | yes"));
}

TEST(Bench, FindsTheMostCameras) {
  const Outcome o =
      run_glint({"bench", "--device", "cpu", "--threads", "1", "-n", "20", "--max-time", "0.1", "--cameras",
                 "1", "--sizes", "320x240", "--blobs", "0", "--headline-rates", "1,10000", "-o", "json"});
  ASSERT_EQ(o.exit_code, 0) << o.err;
  const Json headlines = Json::parse(o.out)["devices"][0]["headlines"];
  ASSERT_EQ(headlines.size(), 2u);
  EXPECT_EQ(headlines[0]["cameras"], 32) << "within a second";
  EXPECT_EQ(headlines[0]["at_limit"], true);
  EXPECT_LT(headlines[1]["cameras"], 32) << "within 0.1 ms: 330 GB/s in one thread";
  EXPECT_THAT(o.err, HasSubstr("most cameras at 1 Hz: trying 32")) << "progress";
}

TEST(Bench, ComparesWithAnOlderRun) {
  const TempDir folder;
  const std::string old = (folder.path() / "old.json").string();
  ASSERT_EQ(bench({"--device", "cpu", "-o", "json", "--no-samples", "--output", old}).exit_code, 0);
  EXPECT_THAT(text_of(old), Not(HasSubstr("samples_s")));
  const Outcome o = bench({"--device", "cpu", "--compare", old});
  ASSERT_EQ(o.exit_code, 0) << o.err;
  EXPECT_THAT(o.out, HasSubstr("new/old"));
  EXPECT_THAT(o.out, HasSubstr("| compared with | old.json: glint "));
  const Outcome csv = bench({"--device", "cpu", "--compare", old, "-o", "csv"});
  EXPECT_THAT(csv.out, HasSubstr(",ratio,verdict,"));
}

TEST(Bench, RefusesFilesThatItCannotUse) {
  const TempDir folder;
  const std::string there = folder.write("there.json", "{\"a\": 1}").string();
  Outcome o = bench({"--device", "cpu", "--output", there});
  EXPECT_EQ(o.exit_code, 1);
  EXPECT_THAT(o.err, HasSubstr("there.json: the file exists already"));
  EXPECT_EQ(text_of(there), "{\"a\": 1}");
  o = bench({"--device", "cpu", "--compare", there});
  EXPECT_EQ(o.exit_code, 1);
  EXPECT_THAT(o.err, HasSubstr("there.json: is not a result of glint bench"));
  EXPECT_EQ(o.out, "");
  o = bench({"--device", "cpu", "--compare", folder.string() + "/none.json"});
  EXPECT_EQ(o.exit_code, 1);
  EXPECT_THAT(o.err, HasSubstr("none.json: cannot be read"));
  o = bench({"--device", "cpu", "--output", folder.string() + "/no/such/folder.json"});
  EXPECT_EQ(o.exit_code, 1);
  EXPECT_THAT(o.err, HasSubstr("there is no such folder"));
  EXPECT_EQ(bench({"--device", "cpu", "--output", there, "--force"}).exit_code, 0);
  EXPECT_THAT(text_of(there), HasSubstr("| glint bench"));
  o = bench({"--device", "cpu"}, {.environment = {}, .program = {}, .standard_output = "/dev/full"});
  EXPECT_EQ(o.exit_code, 1);
  EXPECT_THAT(o.err, HasSubstr("standard output: cannot be written"));
}

TEST(Bench, RefusesWrongOptions) {
  const std::vector<Arguments> wrong{{"--cameras", "33"},
                                     {"--cameras", "0"},
                                     {"--cameras", "four"},
                                     {"--sizes", "1280"},
                                     {"--sizes", "1x1"},
                                     {"--sizes", "99999x99999"},
                                     {"--sizes", "64x64", "--blobs", "500"},
                                     {"--blobs", "-1"},
                                     {"--noise", "-1"},
                                     {"-n", "0"},
                                     {"--max-time", "0"},
                                     {"--rate", "0"},
                                     {"-o", "xml"},
                                     {"--depth", "17"},
                                     {"--noise", "40"},
                                     {"--no-such-option"}};
  for (const Arguments& arguments : wrong) {
    Arguments all{"bench", "--device", "cpu", "--no-headline"};
    all.insert(all.end(), arguments.begin(), arguments.end());
    const Outcome o = run_glint(all);
    EXPECT_EQ(o.exit_code, 2) << ::testing::PrintToString(arguments) << o.err;
    EXPECT_EQ(o.out, "");
    EXPECT_THAT(o.err, HasSubstr("glint: "));
  }
  const Outcome o = bench({"--device", "no such device"});
  EXPECT_EQ(o.exit_code, 1);
  EXPECT_THAT(o.err,
              HasSubstr(gpu::list_devices().empty() ? "no Vulkan device" : "no device \"no such device\""));
}

TEST(Bench, ListsDevices) {
  const Outcome o = run_glint({"bench", "--list-devices"});
  EXPECT_EQ(o.exit_code, 0);
  EXPECT_EQ(run_glint({"devices"}).out.rfind(o.out, 0), 0u)
      << "glint devices begins with the same list, not:\n"
      << o.out;
}

class BenchWithWrongShaders : public ::testing::TestWithParam<std::string> {
 protected:
  RunOptions options_{.environment = {}, .program = GLINT_WITH_WRONG_SHADERS, .standard_output = {}};
};

TEST_P(BenchWithWrongShaders, SaysFailAndGivesNoFigure) {
  const Arguments scene{"--device", GetParam(), "--blobs", "5"};
  const auto with = [&](const std::string& format) {
    Arguments arguments{"bench",     "-n", "5",       "--max-time", "0.1",
                        "--cameras", "1",  "--sizes", "320x240",    "--headline-rates",
                        "90",        "-o", format};
    arguments.insert(arguments.end(), scene.begin(), scene.end());
    return run_glint(arguments, options_);
  };
  const Outcome o = with("md");
  EXPECT_EQ(o.exit_code, 1);
  EXPECT_THAT(o.out, HasSubstr("| **FAIL** |"));
  EXPECT_THAT(o.err, HasSubstr("FAIL: "));
  EXPECT_THAT(o.err, HasSubstr("_undist is "));
  EXPECT_FALSE(std::regex_search(o.out, std::regex("\\| +[0-9]+(\\.[0-9]+)? +\\|"))) << o.out;
  const Outcome json = with("json");
  EXPECT_EQ(json.exit_code, 1);
  EXPECT_THAT(json.out, Not(HasSubstr("p50_s")));
  EXPECT_THAT(json.out, Not(HasSubstr("ticks_per_s")));
  const Json parsed = Json::parse(json.out);
  EXPECT_EQ(parsed["devices"][0]["rows"][0]["outcome"], "FAIL");
  EXPECT_EQ(parsed["devices"][0]["headlines"][0]["outcome"], "FAIL");
  const Outcome csv = with("csv");
  EXPECT_EQ(csv.exit_code, 1);
  EXPECT_THAT(csv.out, HasSubstr(",FAIL,check,,,,,,,,"));
  EXPECT_THAT(csv.out, Not(HasSubstr(",wall,")));
}

TEST_P(BenchWithWrongShaders, HasAnotherShaderHash) {
  const Arguments arguments{"--device", "cpu", "-o", "json"};  // the CPU is right all the same
  const Outcome wrong = bench(arguments, options_), right = bench(arguments);
  ASSERT_EQ(wrong.exit_code, 0) << wrong.err;
  EXPECT_NE(Json::parse(wrong.out)["shader_hash"], Json::parse(right.out)["shader_hash"]);
}

INSTANTIATE_TEST_SUITE_P(Vulkan, BenchWithWrongShaders, ::testing::ValuesIn(vulkan_devices()),
                         [](const auto& tested) { return "device_" + tested.param; });
GTEST_ALLOW_UNINSTANTIATED_PARAMETERIZED_TEST(BenchWithWrongShaders);

}  // namespace
}  // namespace glint::test
