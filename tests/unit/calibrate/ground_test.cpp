// SPDX-License-Identifier: MIT
// Origin and axes from markers with noise, and what is refused.
#include "host/calibrate/ground.hpp"

#include <algorithm>
#include <cmath>
#include <functional>
#include <random>

#include <Eigen/Geometry>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "host/base/error.hpp"
#include "host/calibrate/expected_error.hpp"
#include "host/sim/rig.hpp"

namespace glint {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

constexpr double kNoise_m = 2e-4;

std::string refused(const std::function<void()>& action) {
  try {
    action();
  } catch (const Error& error) {
    return error.what();
  }
  return "not refused";
}

/// The simulated rig as a calibration leaves it: in the frame of the first camera.
struct Unplaced {
  Calibration truth = sim_calibration({});
  Pose world_from_floor = truth.cameras[0].world_from_camera.inverse();  // the floor's frame is the truth
  Calibration calibration = truth;
  std::mt19937_64 random{11};

  Unplaced() { transform(calibration, world_from_floor); }

  Eigen::Vector3d measured(const Eigen::Vector3d& on_floor) {
    std::normal_distribution<double> noise(0.0, kNoise_m);
    return world_from_floor * on_floor + Eigen::Vector3d(noise(random), noise(random), noise(random));
  }
  std::vector<Eigen::Vector3d> in_any_order(std::vector<Eigen::Vector3d> on_floor) {
    std::shuffle(on_floor.begin(), on_floor.end(), random);
    for (Eigen::Vector3d& p : on_floor) p = measured(p);
    return on_floor;
  }
  /// Turn (rad) and shift (m) that are left after placing.
  std::pair<double, double> left(const Pose& new_world_from_world) const {
    const Pose rest = new_world_from_world * world_from_floor;
    return {Eigen::AngleAxisd(rest.rotation).angle(), rest.translation.norm()};
  }
};

TEST(GroundFromLFrame, FindsTheCornerWhateverTheOrder) {
  Unplaced rig;
  for (int i = 0; i < 30; ++i) {
    const auto points = rig.in_any_order({{0, 0, 0.02}, {0.6, 0, 0.02}, {0, 0.4, 0.02}});
    const Ground ground = ground_from_l_frame(points, {{0.6}, {0.4}, 0.02}, rig.calibration);
    const auto [turn, shift] = rig.left(ground.new_world_from_world);
    EXPECT_LT(turn, 4 * kNoise_m / 0.4);
    EXPECT_LT(shift, 5 * kNoise_m);
    EXPECT_LT(ground.fit_rms_m, 3 * kNoise_m);
    EXPECT_THAT(ground.notes, IsEmpty());
  }
}

TEST(GroundFromLFrame, FourMarkersAmongOthers) {
  Unplaced rig;
  const auto points = rig.in_any_order(
      {{0, 0, 0}, {0.2, 0, 0}, {0.6, 0, 0}, {0, 0.4, 0}, {1.0, 1.0, 1.0}, {-0.5, 0.1, 0.3}, {0.3, 0.3, 0.0}});
  const Ground ground = ground_from_l_frame(points, {{0.2, 0.6}, {0.4}, 0.0}, rig.calibration);
  const auto [turn, shift] = rig.left(ground.new_world_from_world);
  EXPECT_LT(turn, 4 * kNoise_m / 0.4);
  EXPECT_LT(shift, 5 * kNoise_m);
}

TEST(GroundFromLFrame, RefusesWhatMakesNoSense) {
  Unplaced rig;
  const auto points = rig.in_any_order({{0, 0, 0}, {0.6, 0, 0}, {0, 0.4, 0}});
  const auto with = [&](const LFrame& frame) {
    return refused([&] { ground_from_l_frame(points, frame, rig.calibration); });
  };
  EXPECT_THAT(with({{0.4}, {0.6}, 0}),
              HasSubstr("the cameras would look from below the floor: turn the L-frame over"));
  EXPECT_THAT(with({{0.7}, {0.4}, 0}),
              HasSubstr("no points fit the L-frame; distances between those found: 0.40"));
  EXPECT_THAT(with({{600}, {400}, 0}), HasSubstr("is one given in millimetres?"));
  EXPECT_THAT(with({{0.2, 0.6}, {0.4}, 0}), HasSubstr("only 3 of the L-frame's 4 markers"));
  EXPECT_THAT(with({{}, {0.4}, 0}), HasSubstr("at least one marker on each arm"));
  EXPECT_THAT(with({{0.6}, {0.4}, 50}), HasSubstr("must be given in metres"));
  const auto alike = rig.in_any_order({{0, 0, 0}, {0.4, 0, 0}, {0, 0.4, 0}});
  EXPECT_THAT(refused([&] {
                ground_from_l_frame(alike, {{0.4}, {0.4}, 0}, rig.calibration);
              }),
              HasSubstr("cannot be told apart"));
  const std::vector<Eigen::Vector3d> many(13, Eigen::Vector3d::Zero());
  EXPECT_THAT(refused([&] {
                ground_from_l_frame(many, {{0.6}, {0.4}, 0}, rig.calibration);
              }),
              HasSubstr("13 points were found where the L-frame has 3"));
}

TEST(GroundFromMarkers, InTheirOrder) {
  Unplaced rig;
  const Ground ground = ground_from_markers(
      rig.measured(Eigen::Vector3d(0, 0, 0.01)), rig.measured(Eigen::Vector3d(1.0, 0, 0.01)),
      rig.measured(Eigen::Vector3d(0.3, 0.8, 0.01)), 0.01, rig.calibration);
  const auto [turn, shift] = rig.left(ground.new_world_from_world);
  EXPECT_LT(turn, 4 * kNoise_m / 0.8);
  EXPECT_LT(shift, 5 * kNoise_m);
  const auto place = [&](const Eigen::Vector3d& x, const Eigen::Vector3d& xy) {
    return refused([&] {
      ground_from_markers(rig.measured(Eigen::Vector3d(0, 0, 0)), rig.measured(x), rig.measured(xy), 0,
                          rig.calibration);
    });
  };
  EXPECT_THAT(place({1, 0, 0}, {0.3, -0.8, 0}), HasSubstr("the third marker must lie to the left"));
  EXPECT_THAT(place({1, 0, 0}, {2, 0.01, 0}), HasSubstr("nearly on one line"));
  EXPECT_THAT(place({0, 0, 0}, {0, 1, 0}), HasSubstr("same place"));
}

TEST(GroundFromBoard, WhicheverWayItsAxesPoint) {
  Unplaced rig;
  for (const double flip : {0.0, M_PI}) {  // OpenCV's boards have z into the paper
    const Pose floor_from_board{Eigen::Quaterniond(Eigen::AngleAxisd(flip, Eigen::Vector3d::UnitX())),
                                {0.0, 0.0, 0.005}};
    const Ground ground = ground_from_board(rig.world_from_floor * floor_from_board, 0.005, rig.calibration);
    const auto [turn, shift] = rig.left(ground.new_world_from_world);
    EXPECT_LT(turn, 1e-9);
    EXPECT_LT(shift, 1e-9);
  }
}

TEST(GroundFromBoard, OnATableNotesTheCameraBelow) {
  Unplaced rig;
  rig.calibration.cameras[2].world_from_camera.translation =
      rig.world_from_floor * Eigen::Vector3d(-2.5, -2.5, 0.4);
  const Pose floor_from_board{Eigen::Quaterniond::Identity(), {0, 0, 0.8}};
  const Ground ground = ground_from_board(rig.world_from_floor * floor_from_board, 0, rig.calibration);
  EXPECT_THAT(ground.notes, ElementsAre("cam3 stands 0.400 m below the floor"));
}

TEST(ProvisionalWorld, HasTheFloorBelowThePoints) {
  Unplaced rig;
  std::vector<Eigen::Vector3d> points;
  std::uniform_real_distribution<double> place(-1.0, 1.0);
  for (int i = 0; i < 4000; ++i)
    points.push_back(rig.world_from_floor *
                     Eigen::Vector3d(place(rig.random), place(rig.random), 1.0 + place(rig.random)));
  const Pose rest = provisional_world_from_world(rig.calibration, points) * rig.world_from_floor;
  EXPECT_LT(rest.translation.norm(), 0.15);
  EXPECT_GT((rest.rotation * Eigen::Vector3d::UnitZ()).z(), std::cos(0.1))
      << "up, but for how the cameras are rolled";
  EXPECT_TRUE(provisional_world_from_world({}, points).translation.isZero());
}

TEST(Transform, LeavesThePicturesAsTheyAre) {
  const Calibration before = sim_calibration({});
  Calibration after = before;
  const Pose move{Eigen::Quaterniond(Eigen::AngleAxisd(0.7, Eigen::Vector3d(1, 2, 3).normalized())),
                  {0.3, -2, 1}};
  transform(after, move, 1.1);
  const Eigen::Vector3d point(0.4, -0.3, 1.2);
  for (std::size_t i = 0; i < before.cameras.size(); ++i) {
    const auto a = Camera(before.cameras[i]).project(point),
               b = Camera(after.cameras[i]).project(move * (1.1 * point));
    ASSERT_TRUE(a && b);
    EXPECT_LT((*a - *b).norm(), 1e-9);
  }
}

/// The expected error of a point is the same in whatever world, but for its scale.
TEST(Transform, CarriesTheUncertaintyAlong) {
  const Calibration before = sim_calibration({});
  std::mt19937_64 random(5);
  std::normal_distribution<double> normal(0.0, 1e-3);
  const Eigen::MatrixXd root = Eigen::MatrixXd::NullaryExpr(24, 24, [&] { return normal(random); });
  CalibrationUncertainty uncertainty;
  uncertainty.covariance = root * root.transpose();
  const Eigen::Vector3d point(0.4, -0.3, 1.2);
  const Eigen::Matrix3d expected = ExpectedError(before, uncertainty).at(point)->calibration_m2;

  Calibration after = before;
  const Pose move{Eigen::Quaterniond(Eigen::AngleAxisd(0.7, Eigen::Vector3d(1, 2, 3).normalized())),
                  {0.3, -2, 1}};
  constexpr double kScale = 1.1;
  transform(after, move, kScale);
  transform(uncertainty, after, move, kScale);
  const Eigen::Matrix3d moved = ExpectedError(after, uncertainty).at(move * (kScale * point))->calibration_m2;
  const Eigen::Matrix3d turn = move.rotation.toRotationMatrix();
  EXPECT_TRUE(moved.isApprox(kScale * kScale * turn * expected * turn.transpose(), 1e-6));
}

TEST(Scale, FromAKnownDistance) {
  EXPECT_DOUBLE_EQ(scale_for_distance({0, 0, 0}, {0, 2, 0}, 2.1), 1.05);
  EXPECT_THAT(refused([] { scale_for_distance({0, 0, 0}, {0, 0, 0}, 1.0); }), HasSubstr("same place"));
  EXPECT_THAT(refused([] {
                scale_for_distance({0, 0, 0}, {0, 1, 0}, 0.0);
              }),
              HasSubstr("more than a millimetre"));
}

}  // namespace
}  // namespace glint
