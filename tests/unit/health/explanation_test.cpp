// SPDX-License-Identifier: MIT
// Turns and delays are found among wrong blobs, and neither where there is none.
#include "host/health/explanation.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

namespace glint::health {
namespace {

constexpr double kFocal_px = 900.0, kNoise_px = 0.1;

CameraCalibration camera() {
  CameraCalibration c;
  c.width_px = 1280;
  c.height_px = 800;
  c.fx_px = c.fy_px = kFocal_px;
  c.cx_px = 639.5;
  c.cy_px = 399.5;
  return c;
}

/// Comparisons all over the image; of each the right blob is missing with that probability, and a wrong one
/// lies anywhere within reach. `offset` moves the right one.
template <typename Offset>
ComparisonWindow window_of(const Offset& offset, double missing, double speed_px_s) {
  std::mt19937_64 random(3);
  std::normal_distribution<double> normal;
  std::uniform_real_distribution<double> unit(-1.0, 1.0);
  ComparisonWindow window;
  for (unsigned n = 0; n < 200; ++n) {
    Comparison c;
    c.at = {0.7 * unit(random), 0.44 * unit(random)};
    c.velocity_px_s = speed_px_s * Eigen::Vector2d(unit(random), unit(random));
    c.covariance_px2 = kNoise_px * kNoise_px * Eigen::Matrix2d::Identity();
    c.px_per_m = 250.0;
    c.clutter_per_px2 = 2e-5;
    c.cell = static_cast<std::uint16_t>(n);
    if (0.5 * (unit(random) + 1.0) >= missing)
      c.offset_px[c.blobs++] = offset(c) + kNoise_px * Eigen::Vector2d(normal(random), normal(random));
    c.offset_px[c.blobs++] = 100.0 * Eigen::Vector2d(unit(random), unit(random));
    window.add(c);
  }
  return window;
}

/// Where a turned camera sees what it saw at `at` before: exact, not linear.
Eigen::Vector2d moved_by(const Eigen::Vector3d& turn_rad, const Eigen::Vector2d& at) {
  const Eigen::AngleAxisd turn(turn_rad.norm(), turn_rad.normalized());
  return kFocal_px * ((turn.inverse() * at.homogeneous()).hnormalized() - at);
}

TEST(Explanation, AllIsWell) {
  const ComparisonWindow window = window_of([](const auto&) { return Eigen::Vector2d::Zero(); }, 0.2, 500.0);
  Explainer explainer(camera());
  const Account well = explainer.all_is_well(window, 1.0);
  EXPECT_EQ(well.seen, 200u);
  EXPECT_NEAR(well.explained, 160.0, 15.0);
  EXPECT_EQ(well.gained, 0u);
  EXPECT_EQ(well.offset_px, 0.0);
  EXPECT_LT(explainer.turned(window, 1.0).log_likelihood - well.log_likelihood, 10.0);
  EXPECT_LT(explainer.delayed(window, 1.0).log_likelihood - well.log_likelihood, 5.0);
}

TEST(Explanation, ATurn) {
  for (const double size : {0.001, 0.01, 0.05}) {
    const Eigen::Vector3d turn = size * Eigen::Vector3d(0.6, -0.7, 0.4);
    const ComparisonWindow window =
        window_of([&](const Comparison& c) { return moved_by(turn, c.at); }, 0.3, 500.0);
    Explainer explainer(camera());
    const Account well = explainer.all_is_well(window, 1.0);
    const TurnAccount turned = explainer.turned(window, 1.0);
    const DelayAccount delayed = explainer.delayed(window, 1.0);
    EXPECT_LT((turned.turn_rad - turn).norm(), 3e-5 + 0.03 * size) << size;
    EXPECT_GT(turned.log_likelihood, well.log_likelihood + 100.0);
    EXPECT_GT(turned.log_likelihood, turned.log_likelihood_unmoved + 100.0);
    EXPECT_GT(turned.log_likelihood, delayed.log_likelihood + 100.0);
    EXPECT_GT(turned.gained_cells, 50u);
  }
}

TEST(Explanation, ADelay) {
  for (const double late_s : {-0.02, 0.008, 0.05}) {
    const ComparisonWindow window = window_of(
        [&](const Comparison& c) { return Eigen::Vector2d(late_s * c.velocity_px_s); }, 0.3, 1500.0);
    Explainer explainer(camera());
    const Account well = explainer.all_is_well(window, 1.0);
    const TurnAccount turned = explainer.turned(window, 1.0);
    const DelayAccount delayed = explainer.delayed(window, 1.0);
    EXPECT_NEAR(delayed.late_s, late_s, 2e-4 + 0.01 * std::abs(late_s));
    EXPECT_GT(delayed.log_likelihood, well.log_likelihood + 100.0);
    EXPECT_GT(delayed.log_likelihood, turned.log_likelihood + 100.0);
  }
}

TEST(Explanation, NoBlobsNoEvidence) {
  ComparisonWindow window;
  for (int n = 0; n < 50; ++n) window.add(Comparison{});
  Explainer explainer(camera());
  EXPECT_EQ(explainer.all_is_well(window, 1.0).seen, 0u);
  EXPECT_EQ(explainer.turned(window, 1.0).log_likelihood, 0.0);
  EXPECT_EQ(explainer.delayed(window, 1.0).log_likelihood, 0.0);
  window.clear();
  EXPECT_EQ(explainer.turned(window, 1.0).explained, 0u);
}

TEST(ComparisonWindow, ForgetsTheOldest) {
  ComparisonWindow window;
  for (std::size_t n = 0; n < ComparisonWindow::kCapacity + 10; ++n) {
    Comparison c;
    c.time_s = static_cast<double>(n);
    window.add(c);
  }
  EXPECT_EQ(window.size(), ComparisonWindow::kCapacity);
  EXPECT_EQ(window[0].time_s, 10.0);
  window.forget_before(20.0);
  EXPECT_EQ(window.size(), ComparisonWindow::kCapacity - 10);
  EXPECT_EQ(window[0].time_s, 20.0);
}

}  // namespace
}  // namespace glint::health
