// SPDX-License-Identifier: MIT
// Extrinsics from simulated samples against the truth, and what is refused.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <random>

#include "host/base/error.hpp"
#include "host/calibrate/extrinsics.hpp"
#include "tests/unit/calibrate/waved_target.hpp"

namespace glint {
namespace {

using ::testing::HasSubstr;

const Target kWand = wand_target({0.0, 0.13, 0.39}, 0.0063);

Calibration rig_of(std::uint32_t cameras) {
  SimOptions options;
  options.cameras = cameras;
  return sim_calibration(options);
}

/// The same lenses, and no idea of the poses.
std::vector<CameraCalibration> lenses_of(const Calibration& rig) {
  std::vector<CameraCalibration> lenses = rig.cameras;
  for (CameraCalibration& camera : lenses) camera.world_from_camera = {};
  return lenses;
}

std::string refusal(const SampleSet& samples, const std::vector<CameraCalibration>& lenses,
                    const ExtrinsicsOptions& options = {}) {
  try {
    solve_extrinsics(samples, lenses, options);
  } catch (const Error& e) {
    return e.what();
  }
  return "not refused";
}

TEST(Extrinsics, AWandOfThreePlacesFourCameras) {
  const Calibration rig = rig_of(4);
  const ExtrinsicsResult result = solve_extrinsics(test::wave(rig, kWand, 500, 0.05), lenses_of(rig), {});
  EXPECT_TRUE(result.adjustment.converged);
  EXPECT_LT(test::worst_position_m(result.calibration, rig), 0.3e-3);
  EXPECT_NEAR(result.uncertainty.sigma_px, 0.05, 0.003);
  EXPECT_EQ(result.quality.outliers, 0u);
  ASSERT_EQ(result.quality.lengths.size(), 3u);
  for (const LengthQuality& length : result.quality.lengths) EXPECT_LT(length.error_m.p95, 0.6e-3);
}

TEST(Extrinsics, AWandOfTwoWhoseEndsLookAlikePlacesThemAsWell) {
  const Calibration rig = rig_of(4);
  const Target wand = wand_target({0.0, 0.5}, 0.0063);
  const ExtrinsicsResult result = solve_extrinsics(test::wave(rig, wand, 500, 0.05), lenses_of(rig), {});
  EXPECT_LT(test::worst_position_m(result.calibration, rig), 0.4e-3);
  EXPECT_LE(result.quality.outliers, 2u);
}

TEST(Extrinsics, OneMarkerDoesWithTheDistanceOfTwoCameras) {
  const Calibration rig = rig_of(4);
  const SampleSet samples = test::wave(rig, marker_target(0.0063), 1500, 0.05);
  EXPECT_THAT(refusal(samples, lenses_of(rig)), HasSubstr("tells no scale"));
  ExtrinsicsOptions options;
  options.camera_distance = KnownCameraDistance{
      0, 2,
      (rig.cameras[0].world_from_camera.translation - rig.cameras[2].world_from_camera.translation).norm()};
  const ExtrinsicsResult result = solve_extrinsics(samples, lenses_of(rig), options);
  EXPECT_LT(test::worst_position_m(result.calibration, rig), 0.5e-3);
}

TEST(Extrinsics, TheSameSamplesGiveTheSameCalibrationToTheLastDigit) {
  const Calibration rig = rig_of(4);
  const SampleSet samples = test::wave(rig, kWand, 300, 0.05);
  ExtrinsicsOptions options;
  options.refine_intrinsics = true;
  const ExtrinsicsResult a = solve_extrinsics(samples, lenses_of(rig), options);
  const ExtrinsicsResult b = solve_extrinsics(samples, lenses_of(rig), options);
  for (std::size_t c = 0; c < 4; ++c) {
    const CameraCalibration &x = a.calibration.cameras[c], &y = b.calibration.cameras[c];
    EXPECT_EQ(intrinsics_of(x), intrinsics_of(y));
    EXPECT_EQ(x.world_from_camera.translation, y.world_from_camera.translation);
    EXPECT_EQ(x.world_from_camera.rotation.coeffs(), y.world_from_camera.rotation.coeffs());
  }
}

TEST(Extrinsics, OutliersAreLeftOutAndCounted) {
  const Calibration rig = rig_of(4);
  SampleSet samples = test::wave(rig, kWand, 500, 0.05);
  for (std::size_t i = 0; i < samples.sightings.size(); i += 97) samples.sightings[i].pixel.x() += 25.0;
  const ExtrinsicsResult result = solve_extrinsics(samples, lenses_of(rig), {});
  EXPECT_LT(test::worst_position_m(result.calibration, rig), 0.4e-3);
  EXPECT_GT(result.quality.outliers, 30u);
  EXPECT_THAT(result.notes, ::testing::Contains(HasSubstr("standard deviations off were left out")));
}

TEST(Extrinsics, WrongLensesAreRefinedWithinTheirPrior) {
  const Calibration rig = rig_of(4);
  std::vector<CameraCalibration> lenses = lenses_of(rig);
  double sign = 1.0;
  for (CameraCalibration& camera : lenses) {
    camera.fx_px *= 1.0 + sign * 0.004, camera.fy_px *= 1.0 + sign * 0.004, camera.cx_px += 3.0;
    sign = -sign;
  }
  const SampleSet samples = test::wave(rig, kWand, 1000, 0.05);
  ExtrinsicsOptions options;
  const ExtrinsicsResult fixed = solve_extrinsics(samples, lenses, options);
  options.refine_intrinsics = true;
  const ExtrinsicsResult refined = solve_extrinsics(samples, lenses, options);
  std::printf("held out: %.4f px, refined %.4f px; positions %.3f mm, refined %.3f mm\n",
              fixed.quality.held_out_rms_px, refined.quality.held_out_rms_px,
              1e3 * test::worst_position_m(fixed.calibration, rig),
              1e3 * test::worst_position_m(refined.calibration, rig));
  EXPECT_LT(refined.quality.held_out_rms_px, 0.9 * fixed.quality.held_out_rms_px);
  for (std::size_t c = 0; c < 4; ++c)
    EXPECT_NEAR(refined.calibration.cameras[c].fx_px, rig.cameras[c].fx_px, 0.4);
  EXPECT_LT(test::worst_position_m(refined.calibration, rig), 1e-3);
}

TEST(Extrinsics, OneBumpedCameraIsPlacedAnewWhileTheOthersStay) {
  const Calibration rig = rig_of(4);
  Calibration bumped = rig;
  bumped.cameras[2].world_from_camera.rotation =
      bumped.cameras[2].world_from_camera.rotation *
      Eigen::Quaterniond(Eigen::AngleAxisd(0.05, Eigen::Vector3d::UnitY()));
  bumped.cameras[2].world_from_camera.translation.x() += 0.03;
  ExtrinsicsOptions options;
  options.only = {2};
  const ExtrinsicsResult result =
      solve_extrinsics(test::wave(bumped, kWand, 300, 0.05), rig.cameras, options);
  for (const std::size_t c : std::vector<std::size_t>{0, 1, 3}) {
    EXPECT_LT((result.calibration.cameras[c].world_from_camera.translation -
               rig.cameras[c].world_from_camera.translation)
                  .norm(),
              1e-12);
  }
  const Pose &found = result.calibration.cameras[2].world_from_camera,
             &truth = bumped.cameras[2].world_from_camera;
  EXPECT_LT((found.translation - truth.translation).norm(), 0.5e-3);
  EXPECT_LT(found.rotation.angularDistance(truth.rotation), 2e-4);
}

TEST(Extrinsics, SoItIsByAWandOfTwoWhoseEndsLookAlikeAndWhereOneCameraSeesNothing) {
  const Calibration rig = rig_of(4);
  Calibration bumped = rig;
  bumped.cameras[2].world_from_camera.rotation =
      bumped.cameras[2].world_from_camera.rotation *
      Eigen::Quaterniond(Eigen::AngleAxisd(0.5, Eigen::Vector3d::UnitZ()));
  SampleSet samples = test::wave(bumped, wand_target({0.0, 0.5}, 0.0063), 300, 0.05);
  std::erase_if(samples.sightings, [](const Sighting& s) { return s.camera == 3; });
  ExtrinsicsOptions options;
  options.only = {2};
  const ExtrinsicsResult result = solve_extrinsics(samples, rig.cameras, options);
  const Pose &found = result.calibration.cameras[2].world_from_camera,
             &truth = bumped.cameras[2].world_from_camera;
  EXPECT_LT((found.translation - truth.translation).norm(), 1e-3);
  EXPECT_LT(found.rotation.angularDistance(truth.rotation), 3e-4);
  EXPECT_EQ(result.calibration.cameras[3].world_from_camera.translation,
            rig.cameras[3].world_from_camera.inverse().inverse().translation);
  for (const std::string& note : result.notes) EXPECT_EQ(note.find("nan"), std::string::npos) << note;
}

TEST(Extrinsics, OutliersOfTwoCamerasAreCountedToo) {
  const Calibration rig = rig_of(2);
  SampleSet samples = test::wave(rig, kWand, 500, 0.05);
  for (std::size_t i = 0; i < samples.sightings.size(); i += 97) samples.sightings[i].pixel.y() += 25.0;
  const ExtrinsicsResult result = solve_extrinsics(samples, lenses_of(rig), {});
  EXPECT_GT(result.quality.outliers, 15u);
}

/// Monte Carlo: the standard deviations that are promised are those that are found.
TEST(Extrinsics, StandardDeviationsAreTrue) {
  const Calibration rig = rig_of(4);
  double squares = 0.0, promised = 0.0;
  constexpr int kRuns = 24;
  for (std::uint32_t run = 1; run <= kRuns; ++run) {
    ExtrinsicsOptions options;
    options.hold_out = false;
    options.length_sd_m = 1e-5;  // simulated wands neither bend nor were measured wrongly
    const ExtrinsicsResult result =
        solve_extrinsics(test::wave(rig, kWand, 150, 0.1, run), lenses_of(rig), options);
    Eigen::Matrix3Xd from(3, 4), to(3, 4);
    for (Eigen::Index c = 0; c < 4; ++c) {
      from.col(c) = result.calibration.cameras[static_cast<std::size_t>(c)].world_from_camera.translation;
      to.col(c) = rig.cameras[static_cast<std::size_t>(c)].world_from_camera.translation;
      const Eigen::Matrix3d rotation = result.calibration.cameras[static_cast<std::size_t>(c)]
                                           .world_from_camera.rotation.toRotationMatrix();
      const Eigen::Vector3d t =
          result.calibration.cameras[static_cast<std::size_t>(c)].world_from_camera.inverse().translation;
      // The position is -R^T t, and moves with both.
      Eigen::Matrix<double, 3, 6> by_pose;
      Eigen::Matrix3d cross;
      cross << 0.0, -t.z(), t.y(), t.z(), 0.0, -t.x(), -t.y(), t.x(), 0.0;
      by_pose << -rotation * cross, -rotation;
      promised +=
          (by_pose * result.uncertainty.covariance.block<6, 6>(6 * c, 6 * c) * by_pose.transpose()).trace();
    }
    const Eigen::Matrix4d t = Eigen::umeyama(from, to, false);
    squares += (((t.topLeftCorner<3, 3>() * from).colwise() + Eigen::Vector3d(t.topRightCorner<3, 1>())) - to)
                   .squaredNorm();
  }
  std::printf("camera positions: promised %.3f mm rms, found %.3f mm\n",
              1e3 * std::sqrt(promised / kRuns / 4), 1e3 * std::sqrt(squares / kRuns / 4));
  // 24 runs of 5 free numbers each: 120 degrees of freedom, 6.5 % of standard deviation.
  EXPECT_NEAR(std::sqrt(squares / promised), 1.0, 0.2);
}

TEST(Extrinsics, WhatCannotWorkIsRefusedWithTheReason) {
  const Calibration rig = rig_of(4);
  const std::vector<CameraCalibration> lenses = lenses_of(rig);
  EXPECT_THAT(refusal(test::wave(rig, kWand, 20, 0.05), lenses), HasSubstr("only 20 samples"));

  SampleSet samples = test::wave(rig, kWand, 300, 0.05);
  std::erase_if(samples.sightings, [](const Sighting& s) { return s.camera == 3 && s.tick % 2 == 0; });
  std::erase_if(samples.sightings, [](const Sighting& s) { return s.camera != 3 && s.tick % 2 == 1; });
  EXPECT_THAT(refusal(samples, lenses),
              HasSubstr("cam4 cannot be joined to the other cameras: it never saw"));

  samples = test::wave(rig, kWand, 300, 0.05);
  std::erase_if(samples.sightings, [](const Sighting& s) { return (s.camera < 2) != (s.tick % 2 == 0); });
  EXPECT_THAT(refusal(samples, lenses), HasSubstr("neither with one of the others"));

  std::vector<CameraCalibration> small = lenses;
  small[1].width_px = 640;
  EXPECT_THAT(refusal(test::wave(rig, kWand, 300, 0.05), small),
              HasSubstr("1280x800, but its intrinsics are for 640x800"));
}

TEST(Extrinsics, SamplesInOnePlaneAreRefused) {
  const Calibration rig = rig_of(4);
  const std::vector<Camera> cameras(rig.cameras.begin(), rig.cameras.end());
  SampleSet samples;
  samples.target = kWand;
  samples.cameras = test::sample_cameras(rig);
  std::mt19937 random(1);
  std::uniform_real_distribution<double> place(-1.2, 1.2), turn(0.0, 6.28);
  for (std::uint64_t tick = 0; tick < 400; ++tick) {
    const double angle = turn(random);
    const Eigen::Vector3d from(place(random), place(random), 0.5),
        along(std::cos(angle), std::sin(angle), 0.0);
    for (std::uint32_t c = 0; c < 4; ++c)
      for (std::uint32_t point = 0; point < 3; ++point)
        if (const auto pixel = cameras[c].project(from + kWand.points_in_target[point].x() * along))
          samples.sightings.push_back({tick, c, point, *pixel});
  }
  EXPECT_THAT(refusal(samples, lenses_of(rig)), HasSubstr("all samples lie in one plane"));
}

}  // namespace
}  // namespace glint
