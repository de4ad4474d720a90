// SPDX-License-Identifier: MIT
// The Cramer-Rao bound is what the best method reaches, and a plain one does not beat.
#include "host/sim/bound.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>
#include <vector>

#include "host/sim/renderer.hpp"

namespace glint {
namespace {

constexpr std::uint32_t kWidth = 1280;
constexpr double kWindow_grey = 0.5;  // pixels with less light than that are left out of the centroid

SimOptions one_still_marker(std::uint64_t seed) {
  SimOptions options;
  options.markers = 1;
  options.max_speed_m_s = 0.0;
  options.bright_spots = 0;
  options.seed = seed;
  return options;
}

/// Variances of estimates of x over many noisy images of one marker. The estimators see each image's
/// difference from the mean image, so that fixed pattern and stray light cancel.
struct Trial {
  double likelihood_x2 = 0.0, centroid_x2 = 0.0, bound_x2 = 0.0;
};

Trial run_trial(std::uint64_t seed) {
  const Scene scene(one_still_marker(seed));
  sim::Renderer renderer(scene);
  PositionBound bound(scene);
  TickTruth truth;
  scene.truth(0, truth);
  Trial trial;
  if ((truth.markers[0].clean & 1u) == 0) return trial;
  const Eigen::Matrix2d information = bound.information_px(truth, 0, 0);
  trial.bound_x2 = information.inverse()(0, 0);

  const sim::MarkerView view = truth.views_of(0)[0];
  sim::MarkerPainter painter(scene);
  const sim::Patch& patch = *painter.paint(0, 0, 0, truth.views_of(0), true);
  constexpr int kTicks = 600;
  const auto width = static_cast<std::size_t>(patch.width_px()),
             height = static_cast<std::size_t>(patch.height_px());
  std::vector<std::vector<double>> images;
  std::vector<double> mean(width * height);
  std::vector<std::uint8_t> pixels(kWidth * 800);
  sim::BufferMemory memory;
  for (int tick = 0; tick < kTicks; ++tick) {
    renderer.render(0, static_cast<std::uint64_t>(tick), pixels.data(), kWidth, memory);
    std::vector<double>& image = images.emplace_back(width * height);
    for (std::size_t y = 0; y < height; ++y) {
      for (std::size_t x = 0; x < width; ++x) {
        const std::size_t at = (static_cast<std::size_t>(patch.y_min_px()) + y) * kWidth +
                               static_cast<std::size_t>(patch.x_min_px()) + x;
        image[y * width + x] = pixels[at];
        mean[y * width + x] += pixels[at] / double{kTicks};
      }
    }
  }
  const sim::NoiseModel& noise = renderer.noise();
  const float dark = noise.black_grey + static_cast<float>(scene.glow(0).grey_at(view.x_px, view.y_px));
  for (const std::vector<double>& image : images) {
    // One Fisher scoring step from the truth: the maximum-likelihood estimate to first order.
    Eigen::Vector2d score = Eigen::Vector2d::Zero();
    double weight_sum = 0.0, weight_x = 0.0;
    for (std::size_t y = 0; y < height; ++y) {
      for (std::size_t x = 0; x < width; ++x) {
        const auto row = static_cast<int>(y);
        const double off = image[y * width + x] - mean[y * width + x];
        const double light = static_cast<double>(patch.row(row)[x]);
        const double variance =
            static_cast<double>(noise.variance_grey2(dark + patch.row(row)[x])) + 1.0 / 12.0;
        score -= Eigen::Vector2d(static_cast<double>(patch.row_by_x(row)[x]),
                                 static_cast<double>(patch.row_by_y(row)[x])) *
                 (off / variance);
        if (light > kWindow_grey) {
          const double column = static_cast<double>(patch.x_min_px()) + static_cast<double>(x) - view.x_px;
          weight_sum += light + off;
          weight_x += (light + off) * column;
        }
      }
    }
    trial.likelihood_x2 += std::pow((information.inverse() * score).x(), 2) / kTicks;
    trial.centroid_x2 += std::pow(weight_x / weight_sum, 2) / kTicks;
  }
  // The centroid of a window has an offset of its own, and follows a shift of the blob by a little less than
  // that shift.
  double weight_sum = 0.0, weight_x = 0.0, followed = 0.0;
  for (std::size_t y = 0; y < height; ++y) {
    for (std::size_t x = 0; x < width; ++x) {
      const double light = static_cast<double>(patch.row(static_cast<int>(y))[x]);
      if (light <= kWindow_grey) continue;
      const double column = static_cast<double>(patch.x_min_px()) + static_cast<double>(x) - view.x_px;
      weight_sum += light;
      weight_x += light * column;
      followed -= static_cast<double>(patch.row_by_x(static_cast<int>(y))[x]) * column;
    }
  }
  const double offset = weight_x / weight_sum, gain = followed / weight_sum;
  trial.centroid_x2 = (trial.centroid_x2 - offset * offset) / (gain * gain);
  return trial;
}

TEST(PositionBound, TheLikelihoodEstimateReachesItAndTheCentroidDoesNotBeatIt) {
  int trials = 0;
  double likelihood = 0.0, centroid = 0.0;
  for (std::uint64_t seed = 1; seed <= 6; ++seed) {
    const Trial trial = run_trial(seed);
    if (trial.bound_x2 == 0.0) continue;
    ++trials;
    likelihood += trial.likelihood_x2 / trial.bound_x2;
    centroid += trial.centroid_x2 / trial.bound_x2;
  }
  ASSERT_GE(trials, 3);
  // Variances; 600 images a trial give each ratio 6 %.
  EXPECT_NEAR(likelihood / trials, 1.0, 0.12);
  EXPECT_GT(centroid / trials, 1.0);
  EXPECT_LT(std::sqrt(centroid / trials), 2.0);
}

TEST(PositionBound, MoreLightAndMoreCamerasHelp) {
  SimOptions options = one_still_marker(1);
  options.markers = 10;
  const auto mean_variance = [](const SimOptions& wanted) {
    const Scene scene(wanted);
    PositionBound bound(scene);
    TickTruth truth;
    scene.truth(0, truth);
    double sum = 0.0;
    int count = 0;
    for (std::uint32_t m = 0; m < scene.markers(); ++m) {
      const double variance = bound.variance_m2(truth, m);
      if (!std::isfinite(variance)) continue;
      sum += variance;
      ++count;
    }
    return sum / count;
  };
  const double plain = mean_variance(options);
  EXPECT_GT(std::sqrt(plain), 0.01e-3);
  EXPECT_LT(std::sqrt(plain), 0.08e-3);
  SimOptions noisy = options;
  noisy.faults.extra_noise_grey = 5.0;
  EXPECT_GT(mean_variance(noisy), 2.0 * plain);
  SimOptions more = options;
  more.cameras = 12;
  EXPECT_LT(mean_variance(more), 0.7 * plain);
}

TEST(PositionBound, OneCameraBoundsNothing) {
  SimOptions options = one_still_marker(1);
  options.cameras = 1;
  const Scene scene(options);
  PositionBound bound(scene);
  TickTruth truth;
  scene.truth(0, truth);
  EXPECT_EQ(bound.variance_m2(truth, 0), std::numeric_limits<double>::infinity());
}

}  // namespace
}  // namespace glint
