// SPDX-License-Identifier: MIT
// The predicted error of a point against a simulation with many wrong calibrations.
#include "host/calibrate/expected_error.hpp"

#include <cmath>
#include <random>

#include <gtest/gtest.h>

#include "host/geometry/triangulate.hpp"
#include "host/sim/rig.hpp"

namespace glint {
namespace {

constexpr double kSigma_px = 0.1;

/// A covariance with correlations between cameras, about as a wand calibration leaves it: 0.5 mm, 0.01
/// degrees and, with intrinsics, 0.5 px.
CalibrationUncertainty made_up(std::size_t cameras, bool intrinsics, std::mt19937_64& random) {
  const Eigen::Index block = intrinsics ? 15 : 6, size = block * static_cast<Eigen::Index>(cameras);
  Eigen::VectorXd sd(size);
  for (Eigen::Index i = 0; i < size; ++i) {
    const Eigen::Index k = i % block;
    sd[i] = k < 3 ? 1.7e-4 : k < 6 ? 5e-4 : k < 10 ? 0.5 : k < 12 ? 1e-3 : 1e-4;
  }
  std::normal_distribution<double> normal;
  Eigen::MatrixXd mixing = Eigen::MatrixXd::NullaryExpr(size, size, [&] { return normal(random); });
  mixing = 0.5 * mixing / std::sqrt(static_cast<double>(size)) + Eigen::MatrixXd::Identity(size, size);
  CalibrationUncertainty uncertainty;
  uncertainty.intrinsics = intrinsics;
  uncertainty.covariance = sd.asDiagonal() * (mixing * mixing.transpose()) * sd.asDiagonal();
  uncertainty.sigma_px = kSigma_px;
  return uncertainty;
}

/// The calibration with an error drawn from its covariance.
Calibration drawn(const Calibration& truth, const Eigen::MatrixXd& root, bool intrinsics,
                  std::mt19937_64& random) {
  std::normal_distribution<double> normal;
  const Eigen::VectorXd d = root * Eigen::VectorXd::NullaryExpr(root.cols(), [&] { return normal(random); });
  Calibration wrong = truth;
  for (std::size_t i = 0; i < wrong.cameras.size(); ++i) {
    CameraCalibration& camera = wrong.cameras[i];
    const Eigen::VectorXd part =
        d.segment(static_cast<Eigen::Index>(i) * (intrinsics ? 15 : 6), intrinsics ? 15 : 6);
    Pose camera_from_world = camera.world_from_camera.inverse();
    const Eigen::Vector3d turn = part.head<3>();
    camera_from_world.rotation =
        Eigen::Quaterniond(Eigen::AngleAxisd(turn.norm(), turn.normalized())) * camera_from_world.rotation;
    camera_from_world.translation += part.segment<3>(3);
    camera.world_from_camera = camera_from_world.inverse();
    if (!intrinsics) continue;
    Intrinsics all = intrinsics_of(camera);
    for (std::size_t k = 0; k < all.size(); ++k) all[k] += part[static_cast<Eigen::Index>(6 + k)];
    set_intrinsics(camera, all);
  }
  return wrong;
}

struct Simulated {
  double rms_m = 0.0;
  unsigned views = 0;
};

/// Triangulates with wrong calibrations and noise, as the tracker would.
Simulated simulate(const Calibration& truth, const CalibrationUncertainty& uncertainty,
                   const Eigen::Vector3d& point, double sigma_px, std::mt19937_64& random) {
  std::normal_distribution<double> noise(0.0, sigma_px);
  std::vector<std::pair<std::size_t, Eigen::Vector2d>> pixels;
  for (std::size_t i = 0; i < truth.cameras.size(); ++i) {
    const Camera camera(truth.cameras[i]);
    if (const auto pixel = camera.project(point); pixel && camera.inside(*pixel))
      pixels.emplace_back(i, *pixel);
  }
  Eigen::MatrixXd root;
  if (uncertainty.covariance.size() > 0) root = uncertainty.covariance.llt().matrixL();
  double squares = 0.0;
  constexpr int kTimes = 1500;
  for (int k = 0; k < kTimes; ++k) {
    const Calibration wrong = root.size() > 0 ? drawn(truth, root, uncertainty.intrinsics, random) : truth;
    std::vector<Camera> cameras(wrong.cameras.begin(), wrong.cameras.end());
    std::vector<Observation> views;
    for (const auto& [i, pixel] : pixels)
      views.push_back(
          {&cameras[i], *cameras[i].undistort(pixel + Eigen::Vector2d(noise(random), noise(random)))});
    squares += (triangulate(views, {})->position_in_world - point).squaredNorm();
  }
  return {std::sqrt(squares / kTimes), static_cast<unsigned>(pixels.size())};
}

void expect_agreement(const Calibration& calibration, const CalibrationUncertainty& uncertainty,
                      double sigma_px, std::uint64_t seed) {
  std::mt19937_64 random(seed);
  CalibrationUncertainty known = uncertainty;
  known.sigma_px = sigma_px;
  const ExpectedError expected(calibration, known);
  for (const Eigen::Vector3d& point :
       {Eigen::Vector3d(0, 0, 1), Eigen::Vector3d(1.5, 0.3, 0.2), Eigen::Vector3d(-1.0, 1.2, 1.9)}) {
    const auto error = expected.at(point);
    ASSERT_TRUE(error);
    const Simulated simulated = simulate(calibration, known, point, sigma_px, random);
    EXPECT_EQ(error->views, simulated.views);
    EXPECT_LT(error->rms_m(), 1.1 * simulated.rms_m) << point.transpose();
    EXPECT_GT(error->rms_m(), simulated.rms_m / 1.1) << point.transpose();
  }
}

TEST(ExpectedError, OfNoiseAlone) {
  expect_agreement(sim_calibration({}), {}, kSigma_px, 1);
  const ExpectedError expected(sim_calibration({}), {});
  EXPECT_FALSE(expected.knows_calibration());
}

TEST(ExpectedError, OfPosesAlone) {
  std::mt19937_64 random(2);
  expect_agreement(sim_calibration({}), made_up(4, false, random), 1e-6, 2);
}

TEST(ExpectedError, OfPosesAndIntrinsicsAndNoise) {
  std::mt19937_64 random(3);
  expect_agreement(sim_calibration({}), made_up(4, true, random), kSigma_px, 3);
}

TEST(ExpectedError, OfEightCameras) {
  SimOptions options;
  options.cameras = 8;
  std::mt19937_64 random(4);
  expect_agreement(sim_calibration(options), made_up(8, true, random), kSigma_px, 4);
}

/// A rig that is wrong as a whole, moved or turned, is no error of the shape, but of every point: the size
/// follows.
TEST(ExpectedError, AShiftOfAllCamerasShiftsThePoint) {
  const Calibration calibration = sim_calibration({});
  Eigen::MatrixXd shift = Eigen::MatrixXd::Zero(24, 1);  // by 1 mm along the world's z
  for (std::size_t i = 0; i < 4; ++i) {
    const Eigen::Matrix3d rotation = Camera(calibration.cameras[i]).camera_from_world_rotation();
    shift.block<3, 1>(static_cast<Eigen::Index>(i) * 6 + 3, 0) = rotation * Eigen::Vector3d(0, 0, 0.001);
  }
  CalibrationUncertainty uncertainty;
  uncertainty.covariance = shift * shift.transpose();
  const auto error = ExpectedError(calibration, uncertainty).at({0.3, -0.2, 1.0});
  ASSERT_TRUE(error);
  EXPECT_NEAR(std::sqrt(error->calibration_m2(2, 2)), 0.001, 1e-9);
  EXPECT_NEAR(error->rms_m(), 0.001, 1e-9);
}

TEST(ExpectedError, NothingWhereOneCameraOrNoneSees) {
  const ExpectedError expected(sim_calibration({}), {});
  EXPECT_FALSE(expected.at({0, 0, 5.0}));
  EXPECT_FALSE(expected.at({2.49, 2.49, 1.0}));  // below a camera: only the opposite one sees it
  EXPECT_FALSE(expected.at({30.0, 0, 1.0}));
}

TEST(ExpectedErrorMap, HoldsTheErrorsOfItsCells) {
  const Calibration calibration = sim_calibration({});
  CalibrationUncertainty uncertainty;
  uncertainty.sigma_px = kSigma_px;
  const ExpectedError expected(calibration, uncertainty);
  const ExpectedErrorMap map =
      expected_error_map(expected, horizontal_slice({-3, -3, 0}, {3, 1, 2}, 1.0), 0.1);
  EXPECT_EQ(map.columns, 60u);
  EXPECT_EQ(map.rows, 40u);
  ASSERT_EQ(map.error_m.size(), 2400u);
  EXPECT_TRUE(map.centre_in_world(30, 30).isApprox(Eigen::Vector3d(0.05, 0.05, 1.0)));
  EXPECT_DOUBLE_EQ(map.at(30, 30), expected.at({0.05, 0.05, 1.0})->rms_m());
  EXPECT_TRUE(std::isnan(map.at(0, 0))) << "behind a camera: only the opposite one sees it";

  const ExpectedErrorMap upright =
      expected_error_map(expected, vertical_slice({-3, -2, 0}, {3, 2, 2}, 0.5), 0.5);
  EXPECT_EQ(upright.columns, 12u);
  EXPECT_EQ(upright.rows, 4u);
  EXPECT_TRUE(upright.centre_in_world(0, 3).isApprox(Eigen::Vector3d(-2.75, 0.5, 1.75)));
  EXPECT_LE(expected_error_map(expected, horizontal_slice({-3, -2, 0}, {3, 2, 2}, 1.0), 1e-4).error_m.size(),
            20'200u);
}

TEST(ExpectedErrorAt, CountsWhatTwoCamerasSee) {
  CalibrationUncertainty uncertainty;
  uncertainty.sigma_px = kSigma_px;
  const ExpectedError expected(sim_calibration({}), uncertainty);
  const std::vector<Eigen::Vector3d> points{{0, 0, 1}, {1, 0, 1}, {0, 0, 9}};
  const ExpectedErrorSummary summary = expected_error_at(expected, points);
  EXPECT_EQ(summary.places, 3u);
  EXPECT_EQ(summary.total_m.count, 2u);
  EXPECT_DOUBLE_EQ(summary.total_m.max,
                   std::max(expected.at(points[0])->rms_m(), expected.at(points[1])->rms_m()));
  EXPECT_DOUBLE_EQ(summary.noise_m.max, summary.total_m.max);
  EXPECT_EQ(summary.calibration_m.max, 0.0);
  EXPECT_EQ(expected_error_at(expected, std::vector<Eigen::Vector3d>(5000, points[0]), 100).places, 100u);
}

}  // namespace
}  // namespace glint
