// SPDX-License-Identifier: MIT
// Filled shapes through the blur: light, mean and derivatives are exact far below the pixel.
#include "host/sim/blur.hpp"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <numbers>
#include <vector>

#include "host/sim/random.hpp"
#include "host/sim/rig.hpp"

namespace glint::sim {
namespace {

std::vector<OutlinePoint> ellipse(double x, double y, double a, double b, double tilt, std::size_t count) {
  std::vector<OutlinePoint> outline(count);
  const double step = 2.0 * std::numbers::pi / static_cast<double>(count), c = std::cos(tilt),
               s = std::sin(tilt);
  for (std::size_t i = 0; i < count; ++i) {
    const double u = a * std::cos(step * static_cast<double>(i)),
                 v = b * std::sin(step * static_cast<double>(i));
    const double du = -v * a / b * step, dv = u * b / a * step;
    outline[i] = {x + c * u - s * v, y + s * u + c * v, c * du - s * dv, s * du + c * dv};
  }
  return outline;
}

struct Sums {
  double total = 0.0, x = 0.0, y = 0.0;
};
Sums sums(const Patch& patch) {
  Sums sums;
  for (int y = 0; y < patch.height_px(); ++y) {
    for (int x = 0; x < patch.width_px(); ++x) {
      const double value = static_cast<double>(patch.row(y)[x]);
      sums.total += value;
      sums.x += value * (x + patch.x_min_px());
      sums.y += value * (y + patch.y_min_px());
    }
  }
  sums.x /= sums.total;
  sums.y /= sums.total;
  return sums;
}

TEST(Blur, MeanAndLightOfBallsAreExact) {
  // Real balls through a distorting lens at many sub-pixel places. What is measured against this truth later
  // is of the order of 0.01 px.
  const SimCamera camera(sim_calibration({}).cameras[0]);
  const BlurKernel kernel(0.6);
  Patch patch;
  Random random(3);
  double worst = 0.0;
  for (int i = 0; i < 300; ++i) {
    const double z = random.uniform(1.0, 5.0);
    const Eigen::Vector3d centre(random.uniform(-0.5, 0.5) * z, random.uniform(-0.3, 0.3) * z, z);
    std::vector<OutlinePoint> outline(48), fine(400);
    camera.outline(centre, 0.0063, outline);
    camera.outline(centre, 0.0063, fine);
    const OutlineMoments truth = moments(fine);
    const int x = static_cast<int>(truth.mean_px.x()), y = static_cast<int>(truth.mean_px.y());
    patch.reset(x - 15, y - 15, x + 15, y + 15, false);
    patch.add_filled(kernel, outline, truth.orientation, 100.0);
    const Sums found = sums(patch);
    EXPECT_NEAR(found.total, 100.0 * truth.area_px2, 2e-3 * 100.0 * truth.area_px2);
    worst = std::max(worst, std::hypot(found.x - truth.mean_px.x(), found.y - truth.mean_px.y()));
  }
  EXPECT_LT(worst, 0.003);
  RecordProperty("worst_mean_error_px", std::to_string(worst));
}

TEST(Blur, PixelsAgreeWithBruteForce) {
  const double x0 = 10.37, y0 = 9.81, a = 2.3, b = 1.6, tilt = 0.5, sigma = 0.6;
  const BlurKernel kernel(sigma);
  Patch patch;
  patch.reset(0, 0, 20, 20, false);
  patch.add_filled(kernel, ellipse(x0, y0, a, b, tilt, 48), 1.0, 1.0);
  for (const auto& [px, py] : {std::pair{10, 10}, {12, 10}, {8, 9}, {11, 12}, {13, 12}}) {
    // Integral of (Gaussian * box) over the ellipse, on a grid of 0.01 px.
    double value = 0.0;
    constexpr double kStep = 0.01;
    const auto response = [&](double t) {
      const double root = sigma * std::numbers::sqrt2;
      return 0.5 * (std::erf((t + 0.5) / root) - std::erf((t - 0.5) / root));
    };
    for (double v = y0 - 3.0; v < y0 + 3.0; v += kStep) {
      for (double u = x0 - 3.0; u < x0 + 3.0; u += kStep) {
        const double dx = u - x0, dy = v - y0;
        const double p = (std::cos(tilt) * dx + std::sin(tilt) * dy) / a;
        const double q = (-std::sin(tilt) * dx + std::cos(tilt) * dy) / b;
        if (p * p + q * q < 1.0) value += response(px - u) * response(py - v) * kStep * kStep;
      }
    }
    EXPECT_NEAR(static_cast<double>(patch.row(py)[px]), value, 1e-3) << px << ", " << py;
  }
}

TEST(Blur, GradientIsTheDerivativeOfTheImage) {
  const BlurKernel kernel(0.6);
  Patch here, moved_x, moved_y;
  for (Patch* patch : {&here, &moved_x, &moved_y}) patch->reset(0, 0, 20, 20, true);
  constexpr double kStep = 0.02;
  here.add_filled(kernel, ellipse(10.3, 9.6, 2.0, 1.5, 0.3, 48), 1.0, 100.0);
  moved_x.add_filled(kernel, ellipse(10.3 + kStep, 9.6, 2.0, 1.5, 0.3, 48), 1.0, 100.0);
  moved_y.add_filled(kernel, ellipse(10.3, 9.6 + kStep, 2.0, 1.5, 0.3, 48), 1.0, 100.0);
  for (int y = 0; y <= 20; ++y) {
    for (int x = 0; x <= 20; ++x) {
      // A shape moving by +d changes the image by -d times its derivative.
      const auto slope = [&](const Patch& moved) {
        return static_cast<double>(moved.row(y)[x] - here.row(y)[x]) / kStep;
      };
      EXPECT_NEAR(slope(moved_x), -static_cast<double>(here.row_by_x(y)[x]), 1.5);
      EXPECT_NEAR(slope(moved_y), -static_cast<double>(here.row_by_y(y)[x]), 1.5);
    }
  }
}

TEST(Blur, ClippedPatchEqualsPartOfTheWholeOne) {
  const BlurKernel kernel(0.6);
  Patch whole, part;
  whole.reset(0, 0, 20, 20, false);
  part.reset(9, 10, 20, 20, false);
  for (Patch* patch : {&whole, &part})
    patch->add_filled(kernel, ellipse(10.3, 9.6, 4.0, 3.0, 1.0, 64), 1.0, 50.0);
  for (int y = 10; y <= 20; ++y) {
    for (int x = 9; x <= 20; ++x) EXPECT_NEAR(part.row(y - 10)[x - 9], whole.row(y)[x], 1e-3f);
  }
}

}  // namespace
}  // namespace glint::sim
