// SPDX-License-Identifier: MIT
// Derivatives of the bundle adjustment's residuals against central differences.
#include "host/calibrate/reprojection_cost.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <vector>

#include "host/sim/random.hpp"

namespace glint::test {
namespace {

using Block = std::vector<double>;
constexpr int kStates = 50;

/// Relative to the largest element of its block: what a solver feels.
constexpr double kTolerance = 1e-6;

/// A random camera that sees what lies about two metres before it, and places of points there.
class States {
 public:
  explicit States(std::uint64_t seed) : random_(seed) {}

  double uniform(double low, double high) { return random_.uniform(low, high); }
  Eigen::Vector3d vector(double size) {
    return {uniform(-size, size), uniform(-size, size), uniform(-size, size)};
  }
  Block rotation() {
    Eigen::Vector4d q(uniform(-1, 1), uniform(-1, 1), uniform(-1, 1), uniform(-1, 1));
    q.normalize();
    return {q[0], q[1], q[2], q[3]};
  }
  Block intrinsics() {
    return {uniform(850, 950),    uniform(850, 950),    uniform(600, 680),
            uniform(380, 420),    uniform(-0.35, 0.1),  uniform(-0.1, 0.15),
            uniform(-2e-3, 2e-3), uniform(-2e-3, 2e-3), uniform(-0.03, 0.03)};
  }
  /// The camera's rotation, translation and intrinsics.
  std::vector<Block> camera() {
    return {rotation(), {uniform(-0.3, 0.3), uniform(-0.3, 0.3), uniform(2.0, 4.0)}, intrinsics()};
  }
  SightingTerms terms() {
    return {{uniform(0, 1280), uniform(0, 800)}, uniform(0.03, 0.5), uniform(0.0, 0.05)};
  }

 private:
  sim::Random random_;
};

bool evaluate(const ceres::CostFunction& cost, const std::vector<Block>& blocks,
              std::vector<double>& residuals, std::vector<Block>* jacobians = nullptr) {
  std::vector<const double*> parameters;
  for (const Block& block : blocks) parameters.push_back(block.data());
  residuals.assign(static_cast<std::size_t>(cost.num_residuals()), 0.0);
  if (jacobians == nullptr) return cost.Evaluate(parameters.data(), residuals.data(), nullptr);
  std::vector<double*> rows;
  jacobians->clear();
  // What was there before must not shine through.
  for (const Block& block : blocks) jacobians->emplace_back(residuals.size() * block.size(), 1e300);
  for (Block& jacobian : *jacobians) rows.push_back(jacobian.data());
  return cost.Evaluate(parameters.data(), residuals.data(), rows.data());
}

void expect_right_derivatives(const ceres::CostFunction& cost, std::vector<Block> blocks) {
  std::vector<double> residuals, plus, minus;
  std::vector<Block> jacobians;
  ASSERT_TRUE(evaluate(cost, blocks, residuals, &jacobians));
  ASSERT_TRUE(evaluate(cost, blocks, plus));
  EXPECT_EQ(plus, residuals) << "the residuals depend on whether derivatives are asked for";
  for (std::size_t b = 0; b < blocks.size(); ++b) {
    double largest = 0.0;
    for (const double value : jacobians[b]) largest = std::max(largest, std::abs(value));
    for (std::size_t i = 0; i < blocks[b].size(); ++i) {
      const double value = blocks[b][i], step = 1e-5 * std::max(1.0, std::abs(value));
      blocks[b][i] = value + step;
      ASSERT_TRUE(evaluate(cost, blocks, plus));
      blocks[b][i] = value - step;
      ASSERT_TRUE(evaluate(cost, blocks, minus));
      blocks[b][i] = value;
      for (std::size_t r = 0; r < residuals.size(); ++r) {
        EXPECT_NEAR(jacobians[b][r * blocks[b].size() + i], (plus[r] - minus[r]) / (2.0 * step),
                    kTolerance * std::max(largest, 1.0))
            << "block " << b << ", parameter " << i << ", residual " << r;
      }
    }
  }
}

template <int kTarget>
void check_point_cost(std::uint64_t seed) {
  States states(seed);
  for (int state = 0; state < kStates; ++state) {
    std::vector<Block> blocks = states.camera();
    Block& points = blocks.emplace_back();
    for (int i = 0; i < kTarget; ++i) points.push_back(states.uniform(-0.5, 0.5));
    for (int point = 0; point < kTarget / 3; ++point)
      expect_right_derivatives(PointCost<kTarget>(states.terms(), point), blocks);
  }
}

TEST(ReprojectionCost, DerivativesOfAPoint) {
  check_point_cost<3>(1);
  check_point_cost<6>(2);
  check_point_cost<9>(3);
}

TEST(ReprojectionCost, DerivativesOfABoard) {
  States states(4);
  for (int state = 0; state < kStates; ++state) {
    std::vector<Block> blocks = states.camera();
    Block board = states.rotation();
    for (int i = 0; i < 3; ++i) board.push_back(states.uniform(-0.5, 0.5));
    blocks.push_back(board);
    SightingTerms terms = states.terms();
    terms.marker_radius_m = 0.0;
    expect_right_derivatives(BoardCost(terms, states.vector(0.3)), blocks);
  }
}

TEST(ReprojectionCost, DerivativesOfALength) {
  States states(5);
  for (int state = 0; state < kStates; ++state) {
    Block three;
    for (int i = 0; i < 9; ++i) three.push_back(states.uniform(-0.5, 0.5));
    for (const auto& [a, b] : {std::pair(0, 1), std::pair(1, 2), std::pair(2, 0)})
      expect_right_derivatives(LengthCost<9>(a, b, 0.39, 1e-4), {three});
    expect_right_derivatives(LengthCost<6>(0, 1, 0.5, 1e-4), {{three.begin(), three.begin() + 6}});
  }
}

TEST(ReprojectionCost, DerivativesOfThePrior) {
  States states(6);
  for (int state = 0; state < kStates; ++state) {
    Intrinsics expected{}, sd{};
    const Block a = states.intrinsics(), b = states.intrinsics();
    for (std::size_t i = 0; i < 9; ++i)
      expected[i] = a[i], sd[i] = i % 3 == 1 ? 0.0 : states.uniform(0.5, 2.0);
    const IntrinsicsPrior prior(expected, sd);
    expect_right_derivatives(prior, {b});
    std::vector<double> residuals;
    ASSERT_TRUE(evaluate(prior, {b}, residuals));
    for (std::size_t i = 0; i < 9; ++i)
      EXPECT_DOUBLE_EQ(residuals[i], i % 3 == 1 ? 0.0 : (b[i] - expected[i]) / sd[i]);
  }
}

/// The residual is the projection of the model that tracking uses, minus what was seen, over sigma.
TEST(ReprojectionCost, AgreesWithTheCameraModel) {
  States states(7);
  for (int state = 0; state < kStates; ++state) {
    std::vector<Block> blocks = states.camera();
    CameraCalibration calibration;
    Intrinsics intrinsics{};
    std::copy(blocks[2].begin(), blocks[2].end(), intrinsics.begin());
    set_intrinsics(calibration, intrinsics);
    EXPECT_EQ(intrinsics_of(calibration), intrinsics);
    const Pose camera_from_world{Eigen::Quaterniond(blocks[0].data()),
                                 {blocks[1][0], blocks[1][1], blocks[1][2]}};
    calibration.world_from_camera = camera_from_world.inverse();
    const Eigen::Vector3d point = states.vector(0.5);
    const auto pixel = Camera(calibration).project(point);
    ASSERT_TRUE(pixel);
    SightingTerms terms = states.terms();
    terms.marker_radius_m = 0.0;
    blocks.push_back({point.x(), point.y(), point.z()});
    std::vector<double> residuals;
    ASSERT_TRUE(evaluate(PointCost<3>(terms, 0), blocks, residuals));
    EXPECT_NEAR(residuals[0], (pixel->x() - terms.pixel.x()) / terms.sigma_px, 1e-7);
    EXPECT_NEAR(residuals[1], (pixel->y() - terms.pixel.y()) / terms.sigma_px, 1e-7);
  }
}

/// The outline of a sphere is the cone of rays that touch it: rays at the angle asin(r / distance) from its
/// centre. On the line through the image's centre the outline reaches from tan(a - b) to tan(a + b).
TEST(ReprojectionCost, ASphereIsSeenWhereItsOutlineIs) {
  const Intrinsics pinhole{1.0, 1.0, 0.0, 0.0};
  for (const double radius_m : {0.0, 0.0063, 0.05}) {
    for (const double angle : {0.0, 0.2, 0.5}) {
      const double distance_m = 1.5, half = std::asin(radius_m / distance_m);
      PredictedSighting seen;
      ASSERT_TRUE(predict_sighting(
          pinhole.data(), {distance_m * std::sin(angle), 0.0, distance_m * std::cos(angle)}, radius_m, seen));
      EXPECT_NEAR(seen.pixel.x(), 0.5 * (std::tan(angle - half) + std::tan(angle + half)), 1e-12);
      EXPECT_EQ(seen.pixel.y(), 0.0);
    }
  }
}

TEST(ReprojectionCost, DerivativesOfASighting) {
  States states(8);
  for (int state = 0; state < kStates; ++state) {
    Block intrinsics = states.intrinsics();
    Eigen::Vector3d point(states.uniform(-1, 1), states.uniform(-0.7, 0.7), states.uniform(1.5, 4.0));
    const double radius_m = states.uniform(0.0, 0.05);
    PredictedSighting seen, plus, minus;
    ASSERT_TRUE(predict_sighting(intrinsics.data(), point, radius_m, seen));
    const auto compare = [&](double& value, const Eigen::Vector2d& derivative, double scale) {
      const double before = value, step = 1e-5 * std::max(1.0, std::abs(before));
      value = before + step;
      ASSERT_TRUE(predict_sighting(intrinsics.data(), point, radius_m, plus));
      value = before - step;
      ASSERT_TRUE(predict_sighting(intrinsics.data(), point, radius_m, minus));
      value = before;
      EXPECT_LT(((plus.pixel - minus.pixel) / (2.0 * step) - derivative).norm(), kTolerance * scale);
    };
    for (Eigen::Index i = 0; i < 3; ++i)
      compare(point[i], seen.by_point_in_camera.col(i), seen.by_point_in_camera.norm());
    for (Eigen::Index i = 0; i < 9; ++i)
      compare(intrinsics[static_cast<std::size_t>(i)], seen.by_intrinsics.col(i), seen.by_intrinsics.norm());
  }
}

TEST(ReprojectionCost, NothingIsSeenBehindTheCamera) {
  States states(9);
  std::vector<Block> blocks = states.camera();
  blocks[0] = {0.0, 0.0, 0.0, 1.0};
  blocks[1] = {0.0, 0.0, 0.0};
  std::vector<double> residuals;
  std::vector<Block> jacobians;
  for (const double z_m : {-2.0, 0.0}) {
    blocks.resize(3);
    blocks.push_back({0.1, 0.1, z_m});
    EXPECT_FALSE(evaluate(PointCost<3>(states.terms(), 0), blocks, residuals, &jacobians));
    blocks.back() = {0.0, 0.0, 0.0, 1.0, 0.1, 0.1, z_m};
    EXPECT_FALSE(evaluate(BoardCost(states.terms(), Eigen::Vector3d::Zero()), blocks, residuals, &jacobians));
  }
  PredictedSighting seen{.pixel = {1.0, 2.0}, .by_point_in_camera = {}, .by_intrinsics = {}};
  EXPECT_FALSE(predict_sighting(blocks[2].data(), {0.0, 0.0, 0.04}, 0.05, seen)) << "inside the sphere";
  EXPECT_EQ(seen.pixel, Eigen::Vector2d(1.0, 2.0));
  EXPECT_FALSE(evaluate(LengthCost<6>(0, 1, 0.5, 1e-4), {Block(6, 0.25)}, residuals)) << "a length of zero";
}

}  // namespace
}  // namespace glint::test
