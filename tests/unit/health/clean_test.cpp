// SPDX-License-Identifier: MIT
// Whatever makes seeing hard is no reason to accuse a camera.
#include <gtest/gtest.h>

#include <functional>

#include "tests/unit/health/watched_rig.hpp"

namespace glint::testing {
namespace {

struct Hardship {
  const char* name;
  std::function<void(WatchedRigOptions&)> set;
  friend void PrintTo(const Hardship& hardship, std::ostream* out) { *out << hardship.name; }
};

/// A camera that looks past most of the volume.
void turn_away(WatchedRigOptions& o) {
  o.sim.faults.bump = SimBump{1, 0, 0.5};
  Calibration told = Scene(o.sim).calibration();
  told.cameras[1].world_from_camera.rotation =
      Eigen::Quaterniond(Scene(o.sim).camera(1, 0).camera_from_world_rotation().transpose());
  o.calibration = told;
}

/// Calibrations that are a third of a pixel off, and say so.
void blur_calibration(WatchedRigOptions& o) {
  Calibration told = Scene(o.sim).calibration();
  sim::Random random(o.sim.seed);
  for (CameraCalibration& camera : told.cameras) {
    const Eigen::Vector3d axis(random.uniform(-1.0, 1.0), random.uniform(-1.0, 1.0),
                               random.uniform(-1.0, 1.0));
    camera.world_from_camera.rotation =
        (camera.world_from_camera.rotation * Eigen::Quaterniond(Eigen::AngleAxisd(1.7e-4, axis.normalized())))
            .normalized();
    camera.fx_px += random.uniform(-0.3, 0.3);
    camera.cy_px += random.uniform(-0.3, 0.3);
    camera.rms_px = 0.3;
  }
  o.calibration = told;
}

const std::vector<Hardship>& hardships() {
  static const std::vector<Hardship> all{
      {"poles", [](auto& o) { o.sim.occluders = 12; }},
      {"one_marker", [](auto& o) { o.sim.markers = 1; }},
      {"two_markers", [](auto& o) { o.sim.markers = 2; }},
      {"no_marker", [](auto& o) { o.sim.markers = 0; }},
      {"a_hundred_markers", [](auto& o) { o.sim.markers = 100; }},
      {"slow_markers", [](auto& o) { o.sim.markers = 3, o.sim.max_speed_m_s = 0.5; }},
      {"one_marker_at_rest", [](auto& o) { o.sim.markers = 1, o.sim.max_speed_m_s = 0.0; }},
      {"markers_at_rest", [](auto& o) { o.sim.max_speed_m_s = 0.0; }},
      {"lost_frames", [](auto& o) { o.sim.faults.drop_rate = 0.2, o.sim.faults.duplicate_rate = 0.1; }},
      {"reflections", [](auto& o) { o.clutter = 30; }},
      {"reflections_and_poles",
       [](auto& o) { o.clutter = 10, o.sim.markers = 2, o.sim.max_speed_m_s = 1.0, o.sim.occluders = 10; }},
      {"reflections_and_markers_at_rest",
       [](auto& o) { o.clutter = 30, o.sim.max_speed_m_s = 0.0, o.sim.occluders = 6; }},
      {"noise", [](auto& o) { o.centroid_px = 0.15; }},
      {"big_markers", [](auto& o) { o.sim.marker_radius_m = 0.02; }},
      {"a_camera_that_sees_little", turn_away},
      {"a_blurred_calibration", blur_calibration},
      {"two_cameras", [](auto& o) { o.sim.cameras = 2; }},
      {"three_cameras", [](auto& o) { o.sim.cameras = 3; }},
      {"eight_cameras", [](auto& o) { o.sim.cameras = 8; }},
  };
  return all;
}

class GoodCameras : public ::testing::TestWithParam<Hardship> {};

TEST_P(GoodCameras, AreNotAccused) {
  for (const std::uint64_t seed : {31u, 32u, 33u}) {
    WatchedRigOptions options;
    options.sim.seed = seed;
    GetParam().set(options);
    WatchedRig rig(options);
    rig.run(5.0);
    EXPECT_TRUE(rig.events().empty()) << "seed " << seed << ": " << text_of(rig.events());
  }
}

INSTANTIATE_TEST_SUITE_P(Health, GoodCameras, ::testing::ValuesIn(hardships()),
                         [](const auto& tested) { return std::string(tested.param.name); });

TEST(HealthStates, TooLittleIsNotFine) {
  WatchedRigOptions options;
  options.sim.markers = 0;
  WatchedRig rig(options);
  rig.run(2.0);
  for (const CameraReport& camera : rig.health().report().cameras) {
    EXPECT_EQ(camera.state.condition, CameraCondition::Unknown);
    EXPECT_FALSE(camera.green());
    EXPECT_EQ(camera.compared, 0u);
    EXPECT_EQ(camera.residual_px, 0.0);
  }
}

}  // namespace
}  // namespace glint::testing
