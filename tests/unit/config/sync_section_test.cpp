// SPDX-License-Identifier: MIT
// Coded pulses in rig files.
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
}

TEST_F(SyncSection, EveryKeyReachesItsFieldAndIsWrittenAgain) {
  const Rig rig = read("[sync]\ncode_seed = 4294967295\ncode_group = 42\n");
  EXPECT_EQ(rig.sync.code_seed, 4'294'967'295u);
  EXPECT_EQ(rig.sync.code_group, 42u);
  const Rig again = read_rig(folder_.write("again.toml", to_toml(rig)));
  EXPECT_EQ(again.sync.code_seed, rig.sync.code_seed);
  EXPECT_EQ(again.sync.code_group, rig.sync.code_group);
}

TEST_F(SyncSection, RefusesWhatCannotWork) {
  EXPECT_THAT(error_of([&] { read("[sync]\ncode_group = 17\n"); }),
              HasSubstr("sync.code_group must be 0 (as recommended for the rate) or 18 to 1024, not 17"));
  EXPECT_THAT(error_of([&] { read("[sync]\ncode_group = 1025\n"); }), HasSubstr("not 1025"));
  EXPECT_THAT(error_of([&] { read("[sync]\ncode_seed = -1\n"); }), HasSubstr("code_seed"));
  EXPECT_THAT(error_of([&] { read("[sync]\ncode_sed = 1\n"); }), HasSubstr("did you mean \"code_seed\"?"));
}

}  // namespace
}  // namespace glint
