// SPDX-License-Identifier: MIT
// What is written is read back whole; what is damaged or foreign is refused with the place.
#include "host/bench/report_json.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "host/base/error.hpp"
#include "tests/support/temp_dir.hpp"
#include "tests/unit/bench/sample_results.hpp"

namespace glint::bench {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::Not;
using Json = nlohmann::ordered_json;

std::string refusal(const std::string& text) {
  try {
    (void)parse_results(text, "old.json");
  } catch (const Error& e) {
    return e.what();
  }
  return "";
}

/// The sample with one change made to it.
std::string changed(const std::function<void(Json&)>& change) {
  Json json = Json::parse(to_json(test::sample_results(), true));
  change(json);
  return json.dump();
}

TEST(ReportJson, ComesBackWhole) {
  const Results r = test::sample_results();
  const std::string text = to_json(r, true);
  const Results back = parse_results(text, "x");
  EXPECT_EQ(to_json(back, true), text);  // all fields are in the text
  EXPECT_EQ(back.devices[0].rows[0].wall.samples, r.devices[0].rows[0].wall.samples);
  EXPECT_EQ(back.devices[0].rows[1].scene, r.devices[0].rows[1].scene);
  EXPECT_EQ(back.devices[1].rows[0].outcome, Outcome::Wrong);
  EXPECT_EQ(back.devices[2].vulkan.has_value(), false);
  EXPECT_EQ(back.devices[0].vulkan->heaps[0].size_bytes, 17'179'869'184u);
  EXPECT_EQ(back.machine.processor, "Some \"Fast\" CPU");
}

TEST(ReportJson, HasItsSchemaAndMarksSoftware) {
  const Json json = Json::parse(to_json(test::sample_results(), true));
  EXPECT_EQ(json["schema"]["name"], "glint-bench");
  EXPECT_EQ(json["schema"]["version"], 1);
  EXPECT_EQ(json["devices"][0]["software"], true);
  EXPECT_EQ(json["devices"][0]["vulkan"]["device_type"], "software");
  EXPECT_EQ(json["devices"][2]["vulkan"], nullptr);
  EXPECT_EQ(json["devices"][0]["rows"][0]["wall"]["samples_s"].size(), 101u);
}

TEST(ReportJson, GivesAWrongDeviceNoFigures) {
  const Json json = Json::parse(to_json(test::sample_results(), true));
  for (const Json& row : json["devices"][1]["rows"]) {
    EXPECT_EQ(row["outcome"], "FAIL");
    EXPECT_EQ(row.size(), 3u) << row.dump();  // scene, outcome, problem
  }
}

TEST(ReportJson, LeavesSamplesOutWhenAsked) {
  const std::string text = to_json(test::sample_results(), false);
  EXPECT_THAT(text, Not(HasSubstr("samples_s")));
  const Results back = parse_results(text, "x");
  EXPECT_TRUE(back.devices[0].rows[0].wall.samples.empty());
  EXPECT_EQ(back.devices[0].rows[0].wall.summary.count, 101u);
}

TEST(ReportJson, KeepsSamplesInOneLine) {
  const std::string text = to_json(test::sample_results(), true);
  EXPECT_LT(std::count(text.begin(), text.end(), '\n'), 500);
}

TEST(ReportJson, ListsChanges) {
  const Baseline before{"old.json", test::sample_results()};
  const Json json = Json::parse(to_json(test::sample_results(), false, &before));
  const Json& changes = json["comparison"]["changes"];
  ASSERT_EQ(changes.size(), 3u * 6u);  // rows with figures x series
  EXPECT_EQ(changes[0]["series"], "wall");
  EXPECT_EQ(changes[0]["ratio"], 1.0);
  EXPECT_EQ(changes[0]["verdict"], "same within noise");
}

TEST(ReportJson, RefusesWhatIsNoResult) {
  EXPECT_THAT(refusal(""), HasSubstr("old.json: is damaged or no JSON"));
  EXPECT_THAT(refusal("{\"schema\": "), HasSubstr("old.json: is damaged or no JSON"));
  EXPECT_THAT(refusal("[1, 2]"), HasSubstr("old.json: is not a result of glint bench"));
  EXPECT_THAT(refusal("{}"), HasSubstr("old.json: is not a result of glint bench"));
  EXPECT_THAT(refusal(R"({"schema": {"name": "other", "version": 1}})"), HasSubstr("is not a result"));
  EXPECT_THAT(refusal(R"({"schema": {"name": "glint-bench", "version": 2}})"),
              AllOf(HasSubstr("version 2"), HasSubstr("reads version 1")));
  const std::string whole = to_json(test::sample_results(), true);
  EXPECT_THAT(refusal(whole.substr(0, whole.size() / 2)), HasSubstr("old.json: is damaged"));
}

TEST(ReportJson, NamesThePlaceOfWhatIsWrong) {
  EXPECT_EQ(refusal(changed([](Json& j) { j["devices"][0]["rows"][1]["wall"].erase("p50_s"); })),
            "old.json: devices[0].rows[1].wall: no key \"p50_s\"");
  EXPECT_EQ(refusal(changed([](Json& j) { j["devices"][0]["rows"][1]["wall"]["p50_s"] = "fast"; })),
            "old.json: devices[0].rows[1].wall.p50_s: must be a number");
  EXPECT_EQ(refusal(changed([](Json& j) { j["devices"][0]["rows"][0]["scene"]["cameras"] = -4; })),
            "old.json: devices[0].rows[0].scene.cameras: must be a whole number from 0 to 4294967295");
  EXPECT_EQ(refusal(changed([](Json& j) { j["devices"] = 3; })), "old.json: devices: must be a list");
  EXPECT_EQ(refusal(changed([](Json& j) { j["devices"][1]["software"] = "no"; })),
            "old.json: devices[1].software: must be true or false");
  EXPECT_EQ(refusal(changed([](Json& j) { j["devices"][1]["rows"][0]["outcome"] = "fine"; })),
            "old.json: devices[1].rows[0].outcome: must be \"ok\", \"FAIL\" or \"error\"");
  EXPECT_EQ(refusal(changed([](Json& j) { j["machine"] = nullptr; })),
            "old.json: machine: must be an object");
  EXPECT_EQ(refusal(changed([](Json& j) { j["notes"][0] = 1; })), "old.json: notes[0]: must be a text");
}

TEST(ReportJson, ReadsFiles) {
  const glint::test::TempDir folder;
  const auto good = folder.write("good.json", to_json(test::sample_results(), false));
  EXPECT_EQ(read_results(good).devices.size(), 3u);
  EXPECT_THROW((void)read_results(folder.path() / "missing.json"), Error);
  EXPECT_THROW((void)read_results(folder.path()), Error);
}

}  // namespace
}  // namespace glint::bench
