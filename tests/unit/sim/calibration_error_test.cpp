// SPDX-License-Identifier: MIT
// A disturbed calibration is wrong by what was asked for, measured apart from how it was made.
#include "host/sim/calibration_error.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "host/sim/random.hpp"
#include "host/sim/rig.hpp"

namespace glint {
namespace {

/// Root mean square of the image shift, of random points of the volume.
double rms_shift_px(const CameraCalibration& exact, const CameraCalibration& other) {
  sim::Random random(9);
  const Camera a(exact), b(other);
  double sum = 0.0;
  int count = 0;
  for (int i = 0; i < 20000; ++i) {
    const Eigen::Vector3d point(random.uniform(-1.5, 1.5), random.uniform(-1.5, 1.5),
                                random.uniform(0.0, 2.0));
    const auto from = a.project(point), to = b.project(point);
    if (!from || !to || !a.inside(*from)) continue;
    sum += (*to - *from).squaredNorm();
    ++count;
  }
  return std::sqrt(sum / count);
}

TEST(CalibrationError, ImagesMoveByWhatWasAskedFor) {
  for (const std::uint64_t seed : {1u, 2u, 3u}) {
    for (const double error_px : {0.05, 0.3, 1.0, 5.0}) {
      SimOptions options;
      options.cameras = 6;
      options.seed = seed;
      const Calibration exact = sim_calibration(options), wrong = disturbed(exact, error_px, seed);
      ASSERT_EQ(wrong.cameras.size(), 6u);
      for (std::size_t c = 0; c < 6; ++c) {
        // The grid has the volume's walls in it, random points have not: they differ by a few per cent.
        EXPECT_NEAR(rms_shift_px(exact.cameras[c], wrong.cameras[c]), error_px, 0.12 * error_px);
        EXPECT_EQ(wrong.cameras[c].rms_px, error_px);
        EXPECT_EQ(wrong.cameras[c].fx_px, exact.cameras[c].fx_px);
      }
    }
  }
}

TEST(CalibrationError, TurningAndShiftingHaveEqualShares) {
  const Calibration exact = sim_calibration({}), wrong = disturbed(exact, 1.0, 4);
  for (std::size_t c = 0; c < exact.cameras.size(); ++c) {
    CameraCalibration turned = exact.cameras[c], shifted = exact.cameras[c];
    turned.world_from_camera.rotation = wrong.cameras[c].world_from_camera.rotation;
    shifted.world_from_camera.translation = wrong.cameras[c].world_from_camera.translation;
    const double by_turning = rms_shift_px(exact.cameras[c], turned),
                 by_shifting = rms_shift_px(exact.cameras[c], shifted);
    EXPECT_GT(by_turning, 0.3);
    EXPECT_NEAR(by_turning / by_shifting, 1.0, 0.15);
    const Eigen::Quaterniond turn =
        exact.cameras[c].world_from_camera.rotation.conjugate() * wrong.cameras[c].world_from_camera.rotation;
    for (const double about : turn.vec()) EXPECT_NE(about, 0.0);
  }
}

TEST(CalibrationError, NoneLeavesEverythingAsItWasAndSeedsDiffer) {
  const Calibration exact = sim_calibration({});
  const Calibration same = disturbed(exact, 0.0, 1), one = disturbed(exact, 0.5, 1),
                    again = disturbed(exact, 0.5, 1), other = disturbed(exact, 0.5, 2);
  for (std::size_t c = 0; c < exact.cameras.size(); ++c) {
    const Pose& pose = exact.cameras[c].world_from_camera;
    EXPECT_EQ(same.cameras[c].world_from_camera.translation, pose.translation);
    EXPECT_EQ(same.cameras[c].world_from_camera.rotation.coeffs(), pose.rotation.coeffs());
    EXPECT_EQ(same.cameras[c].rms_px, exact.cameras[c].rms_px);
    EXPECT_EQ(one.cameras[c].world_from_camera.translation, again.cameras[c].world_from_camera.translation);
    EXPECT_NE(one.cameras[c].world_from_camera.translation, other.cameras[c].world_from_camera.translation);
  }
}

}  // namespace
}  // namespace glint
