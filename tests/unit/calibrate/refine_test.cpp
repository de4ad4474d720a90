// SPDX-License-Identifier: MIT
// Refinement from tracked markers: taken if it helps, left if not.
#include <gtest/gtest.h>

#include <numbers>

#include "host/base/error.hpp"
#include "host/calibrate/refine.hpp"
#include "tests/unit/calibrate/waved_target.hpp"

namespace glint {
namespace {

SampleSet markers_of(const Calibration& rig, std::size_t count) {
  const SampleSet waved = test::wave(rig, marker_target(0.0), count, 0.03);
  TrackedSamples tracked(waved.cameras, 0.0);
  for (const SampleTick& tick : ticks_of(waved)) tracked.add(tick.sightings);
  return tracked.take(2000);
}

TEST(Refine, ADriftedRigComesBackAndAGoodOneIsLeftAlone) {
  const Calibration rig = sim_calibration({});
  Calibration drifted = rig;
  drifted.cameras[1].world_from_camera.rotation =
      drifted.cameras[1].world_from_camera.rotation *
      Eigen::Quaterniond(Eigen::AngleAxisd(0.02 * std::numbers::pi / 180.0, Eigen::Vector3d::UnitX()));
  const SampleSet samples = markers_of(rig, 2500);
  const Refinement better = refine(drifted, samples);
  EXPECT_TRUE(better.better) << better.reason;
  EXPECT_LT(better.after.held_out_rms_px, 0.7 * better.before.held_out_rms_px);
  const double left = better.calibration.cameras[1].world_from_camera.rotation.angularDistance(
      rig.cameras[1].world_from_camera.rotation);
  EXPECT_LT(left * 180.0 / std::numbers::pi, 0.007);

  const Refinement same = refine(rig, samples);
  EXPECT_FALSE(same.better) << same.reason;
}

/// Their positions alone leave a turn about the line open.
TEST(Refine, CamerasOnALineStayTurnedAsTheyWere) {
  Calibration rig = sim_calibration({});
  rig.cameras.resize(3);
  const Pose first = rig.cameras[0].world_from_camera;
  for (std::size_t c = 0; c < 3; ++c) {
    rig.cameras[c].world_from_camera = first;
    rig.cameras[c].world_from_camera.translation +=
        0.6 * static_cast<double>(c) * (first.rotation * Eigen::Vector3d::UnitX());
  }
  const Refinement same = refine(rig, markers_of(rig, 2500));
  EXPECT_LT(same.worst_turn_rad, 2e-4);
  EXPECT_LT(same.worst_shift_m, 2e-3);
}

TEST(Refine, TooFewMarkersAreRefused) {
  const Calibration rig = sim_calibration({});
  EXPECT_THROW(refine(rig, markers_of(rig, 100)), Error);
}

}  // namespace
}  // namespace glint
