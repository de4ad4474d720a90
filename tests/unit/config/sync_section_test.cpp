// SPDX-License-Identifier: MIT
// The sync board and its coded pulses in rig files.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "host/config/rig.hpp"
#include "tests/unit/config/config_fixture.hpp"

namespace glint {
namespace {

using test::error_of;
using test::TempFolder;
using ::testing::HasSubstr;

class SyncSection : public ::testing::Test {
 protected:
  SyncSection() {
    Calibration calibration;
    for (const char* name : {"north", "south"}) {
      CameraCalibration& camera = calibration.cameras.emplace_back();
      camera.name = name;
      camera.width_px = camera.height_px = 100;
    }
    write_calibration(folder_ / "cal.toml", calibration);
  }
  Rig read(const std::string& text) {
    return read_rig(folder_.write("rig.toml",
                                  "format = 1\nkind = \"rig\"\n[rig]\nname = \"lab\"\nrate_hz = 90\n"
                                  "calibration = \"cal.toml\"\n" +
                                      text));
  }
  TempFolder folder_;
};

TEST_F(SyncSection, IsOptional) {
  EXPECT_EQ(read("").sync.code_seed, 0u);
  EXPECT_EQ(read("[sync]\n").sync.code_group, 0u);
  EXPECT_EQ(read("").sync.board, "none");
}

TEST_F(SyncSection, EveryKeyReachesItsFieldAndIsWrittenAgain) {
  const Rig rig = read("[sync]\ncode_seed = 4294967295\ncode_group = 42\n");
  EXPECT_EQ(rig.sync.code_seed, 4'294'967'295u);
  EXPECT_EQ(rig.sync.code_group, 42u);
  const Rig again = read_rig(folder_.write("again.toml", to_toml(rig)));
  EXPECT_EQ(again.sync.code_seed, rig.sync.code_seed);
  EXPECT_EQ(again.sync.code_group, rig.sync.code_group);
}

TEST_F(SyncSection, SaysWhichBoardAndWhatItsOutputsDo) {
  const Rig first = read(R"([sync]
board = "E660583883123456"
follow = true
trigger_us = 50
trigger_delay_us = 10
strobe_us = 200
strobe_delay_us = 700
keepalive_ms = 0
sync_out = true
[[sync.output]]
output = 3
enabled = false
[[sync.output]]
output = 5
delay_us = 800
width_us = 20.5
every_n = 3
phase = 2
)");
  for (const Rig& rig : {first, read_rig(folder_.write("again.toml", to_toml(first)))}) {
    EXPECT_EQ(rig.sync.board, "E660583883123456");
    EXPECT_TRUE(rig.sync.follow);
    EXPECT_EQ(rig.sync.trigger_us, 50.0);
    EXPECT_EQ(rig.sync.trigger_delay_us, 10.0);
    EXPECT_EQ(rig.sync.strobe_us, 200.0);
    EXPECT_EQ(rig.sync.strobe_delay_us, 700.0);
    EXPECT_EQ(rig.sync.keepalive_ms, 0u);
    EXPECT_TRUE(rig.sync.sync_out);
    ASSERT_EQ(rig.sync.outputs.size(), 2u);
    EXPECT_FALSE(rig.sync.outputs[0].enabled);
    EXPECT_EQ(rig.sync.outputs[0].width_us, std::nullopt);
    EXPECT_EQ(rig.sync.outputs[1].output, 5u);
    EXPECT_EQ(rig.sync.outputs[1].delay_us, 800.0);
    EXPECT_EQ(rig.sync.outputs[1].width_us, 20.5);
    EXPECT_EQ(rig.sync.outputs[1].every_n, 3u);
    EXPECT_EQ(rig.sync.outputs[1].phase, 2u);
  }
}

TEST_F(SyncSection, RefusesWhatCannotWork) {
  EXPECT_THAT(error_of([&] { read("[sync]\nboard = \"\"\n"); }), HasSubstr("sync.board must be"));
  EXPECT_THAT(error_of([&] { read("[sync]\nfollow = 1\n"); }), HasSubstr("must be true or false"));
  EXPECT_THAT(error_of([&] { read("[sync]\nstrobe_us = -1\n"); }), HasSubstr("sync.strobe_us must be 1 to"));
  EXPECT_THAT(error_of([&] { read("[[sync.output]]\nenabled = true\n"); }), HasSubstr("output"));
  EXPECT_THAT(error_of([&] { read("[[sync.output]]\noutput = 8\n"); }), HasSubstr("output"));
  EXPECT_THAT(error_of([&] { read("[[sync.output]]\noutput = 1\n[[sync.output]]\noutput = 1\n"); }),
              HasSubstr("1 stands here twice"));
  EXPECT_THAT(error_of([&] { read("[[sync.output]]\noutput = 1\nevery_n = 2\nphase = 2\n"); }),
              HasSubstr("phase must be below every_n (2)"));
  EXPECT_THAT(error_of([&] { read("[sync]\ncode_group = 17\n"); }),
              HasSubstr("sync.code_group must be 0 (as recommended for the rate) or 18 to 1024, not 17"));
  EXPECT_THAT(error_of([&] { read("[sync]\ncode_group = 1025\n"); }), HasSubstr("not 1025"));
  EXPECT_THAT(error_of([&] { read("[sync]\ncode_seed = -1\n"); }), HasSubstr("code_seed"));
  EXPECT_THAT(error_of([&] { read("[sync]\ncode_sed = 1\n"); }), HasSubstr("did you mean \"code_seed\"?"));
}

}  // namespace
}  // namespace glint
