// SPDX-License-Identifier: MIT
// The simulated rig stands where it should and its lenses can be inverted.
#include "host/sim/rig.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "gpu/lens.hpp"

namespace glint {
namespace {

TEST(SimRig, FourCornersLookingAtTheMiddle) {
  const Calibration calibration = sim_calibration({});
  ASSERT_EQ(calibration.cameras.size(), 4u);
  for (std::size_t i = 0; i < 4; ++i) {
    const CameraCalibration& camera = calibration.cameras[i];
    EXPECT_EQ(camera.name, "cam" + std::to_string(i + 1));
    const Eigen::Vector3d& at = camera.world_from_camera.translation;
    for (const double off : {std::abs(at.x()) - 2.5, std::abs(at.y()) - 2.5, at.z() - 2.4}) {
      EXPECT_GE(std::abs(off), 0.0099);
      EXPECT_LE(std::abs(off), 0.0501);
    }
    const Eigen::Vector3d forward = camera.world_from_camera.rotation * Eigen::Vector3d::UnitZ();
    const Eigen::Vector3d to_middle = Eigen::Vector3d(0, 0, 1) - at;
    EXPECT_LT(forward.cross(to_middle).norm(), 0.09);  // passes the middle within 9 cm
    EXPECT_GT(forward.dot(to_middle), 0.0);
    const Eigen::Vector3d down = camera.world_from_camera.rotation * Eigen::Vector3d::UnitY();
    EXPECT_LT(down.z(), -0.8);
    EXPECT_GE(camera.fx_px, 914.0);
    EXPECT_LE(camera.fx_px, 933.0);
    EXPECT_NEAR(camera.k1_k2_p1_p2_k3[0], -0.32, 0.0051);
  }
}

TEST(SimRig, LensesInvertEverywhereInTheImage) {
  SimOptions options;
  options.cameras = 32;
  for (const CameraCalibration& camera : sim_calibration(options).cameras) {
    const gpu::Lens lens{camera.fx_px, camera.fy_px, camera.cx_px, camera.cy_px, camera.k1_k2_p1_p2_k3};
    for (double y = 0.0; y < 800.0; y += 799.0 / 8) {
      for (double x = 0.0; x < 1280.0; x += 1279.0 / 8) {
        const gpu::Undistorted at = gpu::undistort(lens, x, y);
        ASSERT_TRUE(at.converged) << camera.name << " at " << x << ", " << y;
        double back_x = 0.0, back_y = 0.0;
        gpu::distort(lens, at.x, at.y, back_x, back_y);
        EXPECT_NEAR(back_x, x, 1e-6);
        EXPECT_NEAR(back_y, y, 1e-6);
      }
    }
  }
}

TEST(SimRig, CamerasDoNotStandOnOneAnother) {
  for (std::uint32_t n : {1u, 2u, 5u, 32u}) {
    SimOptions options;
    options.cameras = n;
    const Calibration calibration = sim_calibration(options);
    ASSERT_EQ(calibration.cameras.size(), n);
    for (std::size_t i = 0; i < n; ++i) {
      for (std::size_t j = i + 1; j < n; ++j) {
        EXPECT_GT((calibration.cameras[i].world_from_camera.translation -
                   calibration.cameras[j].world_from_camera.translation)
                      .norm(),
                  0.5);
      }
    }
  }
}

}  // namespace
}  // namespace glint
