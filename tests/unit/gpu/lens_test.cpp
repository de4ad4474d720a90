// SPDX-License-Identifier: MIT
// The lens model: forwards and backwards agree, folds are reported, and blobs are undistorted as if every
// pixel had been.
#include "gpu/lens.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <random>
#include <vector>

namespace glint::gpu {
namespace {

struct NamedLens {
  const char* name;
  Lens lens;
  double width_px, height_px;
};

/// Invertible everywhere in the image.
std::vector<NamedLens> good_lenses() {
  return {
      {"none", {900, 910, 640, 400, {}}, 1280, 800},
      {"wide", {914, 914, 640, 400, {-0.32, 0.12, 0.0006, -0.0004, -0.015}}, 1280, 800},
      {"wide, off centre", {914, 920, 580, 430, {-0.32, 0.14, -0.002, 0.003, -0.02}}, 1280, 800},
      {"barely unfolded", {914, 914, 640, 400, {-0.32, 0.055, 0, 0, 0}}, 1280, 800},
      {"pincushion", {700, 700, 640, 400, {0.25, 0.1, 0.001, 0.001, 0.02}}, 1280, 800},
      {"long, k2 of 18.8",
       {6488.587866545513,
        6471.767811559866,
        783.097278091372,
        509.29316279382255,
        {-0.0778486546624676, 18.783720840702266, -0.02072902674808729, 0.02205120134649478, 0.0}},
       1280,
       1024},
  };
}

Undistorted undistort(const NamedLens& n, double x, double y) { return gpu::undistort(n.lens, x, y); }

TEST(Lens, IsOpenCvsModel) {
  // By hand: x = 0.5, y = -0.25, r^2 = 0.3125.
  const Lens lens{100, 200, 10, 20, {0.1, -0.2, 0.01, 0.02, 0.3}};
  const double r2 = 0.3125, g = 1 + 0.1 * r2 - 0.2 * r2 * r2 + 0.3 * r2 * r2 * r2;
  const double xd = 0.5 * g + 2 * 0.01 * 0.5 * -0.25 + 0.02 * (r2 + 2 * 0.25);
  const double yd = -0.25 * g + 0.01 * (r2 + 2 * 0.0625) + 2 * 0.02 * 0.5 * -0.25;
  double x_px = 0, y_px = 0;
  distort(lens, 0.5, -0.25, x_px, y_px);
  EXPECT_NEAR(x_px, 100 * xd + 10, 1e-12);
  EXPECT_NEAR(y_px, 200 * yd + 20, 1e-12);
}

TEST(Lens, UndistortInvertsEverywhereInTheImage) {
  for (const NamedLens& n : good_lenses()) {
    for (double y = 0; y <= n.height_px; y += n.height_px / 40) {
      for (double x = 0; x <= n.width_px; x += n.width_px / 64) {
        const Undistorted u = undistort(n, x, y);
        ASSERT_TRUE(u.converged) << n.name << " at " << x << ", " << y;
        double x_px = 0, y_px = 0;
        distort(n.lens, u.x, u.y, x_px, y_px);
        ASSERT_NEAR(x_px, x, 1e-8) << n.name;
        ASSERT_NEAR(y_px, y, 1e-8) << n.name;
      }
    }
  }
}

TEST(Lens, UndistortFindsThePointThatWasDistorted) {
  // Not just any point with that image: the one on the branch that leaves the centre.
  std::mt19937 random(1);
  std::uniform_real_distribution<double> unit(-1.0, 1.0);
  for (const NamedLens& n : good_lenses()) {
    int inside = 0;
    for (int i = 0; i < 2000; ++i) {
      const double x = unit(random) * n.width_px / n.lens.fx_px,
                   y = unit(random) * n.height_px / n.lens.fy_px;
      double x_px = 0, y_px = 0;
      distort(n.lens, x, y, x_px, y_px);
      if (std::hypot(x, y) > 1.1 || x_px < 0 || x_px > n.width_px || y_px < 0 || y_px > n.height_px) continue;
      ++inside;
      const Undistorted u = undistort(n, x_px, y_px);
      ASSERT_TRUE(u.converged) << n.name;
      ASSERT_NEAR(u.x, x, 1e-9) << n.name;
      ASSERT_NEAR(u.y, y, 1e-9) << n.name;
    }
    EXPECT_GT(inside, 200) << n.name;
  }
}

TEST(Lens, ReportsWhereTheModelFoldsOver) {
  // r (1 - 0.32 r^2) has its maximum 0.6804 at r = 1.0206.
  const Lens lens{914, 914, 640, 400, {-0.32, 0, 0, 0, 0}};
  const double fold_px = 914 * 0.680414;
  for (double angle = 0; angle < 6.28; angle += 0.1) {
    for (const double r_px :
         {0.0, 100.0, 400.0, 600.0, fold_px - 0.1, fold_px + 0.1, 640.0, 700.0, 754.0, 2000.0}) {
      const double x_px = 640 + r_px * std::cos(angle), y_px = 400 + r_px * std::sin(angle);
      const Undistorted u = undistort(lens, x_px, y_px);
      EXPECT_EQ(u.converged, r_px < fold_px) << r_px;
      EXPECT_LE(std::hypot(u.x, u.y), 1.0207) << r_px;
      if (r_px > fold_px) {
        EXPECT_GT(std::hypot(u.x, u.y), 1.0) << "the nearest point is at the fold";
      }
    }
  }
}

TEST(Lens, IsNotFooledByASecondBranch) {
  // The radial curve rises to 0.56 at r = 0.88, falls, and rises again: points beyond have a solution far
  // out, which no ray of a real lens takes.
  const Lens lens{1000, 1000, 0, 0, {-0.50, 0.0, 0, 0, 0.05}};
  double previous = 0, fold = 0;
  for (double r = 0; r < 3; r += 1e-4) {
    double x = 0, y = 0;
    distort(lens, r, 0, x, y);
    if (x < previous) {
      fold = previous;
      break;
    }
    previous = x;
  }
  ASSERT_GT(fold, 500);
  EXPECT_TRUE(undistort(lens, fold - 0.5, 0).converged);
  for (double x_px = fold + 0.5; x_px < fold + 2000; x_px += 7.3) {
    const Undistorted u = undistort(lens, x_px, 0);
    ASSERT_FALSE(u.converged) << x_px << " went to " << u.x;
    ASSERT_LT(u.x, 1.1);
  }
}

TEST(Lens, SurvivesNonsense) {
  const Lens lens{914, 914, 640, 400, {-0.32, 0.12, 0, 0, 0}};
  EXPECT_FALSE(undistort(lens, std::nan(""), 0).converged);
  EXPECT_FALSE(undistort(lens, INFINITY, 0).converged);
  EXPECT_FALSE(undistort(Lens{0, 0, 0, 0, {}}, 1, 1).converged);
  (void)undistort(lens, 1e30, -1e30);
  (void)undistort(Lens{1, 1, 0, 0, {1e9, -1e9, 1e9, -1e9, 1e9}}, 3, 4);
}

/// Mean of the undistorted points of a disc, sampled finely, its centroid, and its second moments.
struct Sampled {
  double x = 0, y = 0, cx = 0, cy = 0, xx = 0, xy = 0, yy = 0;
};

Sampled sample_disc(const Lens& lens, double cx, double cy, double diameter_px) {
  constexpr int kSteps = 200;
  std::vector<std::pair<double, double>> points;
  for (int i = 0; i < kSteps; ++i) {
    for (int j = 0; j < kSteps; ++j) {
      const double dx = ((i + 0.5) / kSteps - 0.5) * diameter_px,
                   dy = ((j + 0.5) / kSteps - 0.5) * diameter_px;
      if (std::hypot(dx, dy) <= 0.5 * diameter_px) points.emplace_back(cx + dx, cy + dy);
    }
  }
  Sampled s;
  const double n = static_cast<double>(points.size());
  for (const auto& [x, y] : points) {
    const Undistorted u = undistort(lens, x, y);
    EXPECT_TRUE(u.converged);
    s.x += u.x / n, s.y += u.y / n, s.cx += x / n, s.cy += y / n;
  }
  for (const auto& [x, y] : points) {
    s.xx += (x - s.cx) * (x - s.cx) / n, s.xy += (x - s.cx) * (y - s.cy) / n,
        s.yy += (y - s.cy) * (y - s.cy) / n;
  }
  return s;
}

TEST(Lens, SecondOrderTermEqualsResampling) {
  const Lens lens{914, 914, 640, 400, {-0.32, 0.12, 0.0006, -0.0004, -0.015}};
  for (const double diameter_px : {10.0, 20.0, 40.0}) {
    for (const auto& [cx, cy] :
         {std::pair{22.0, 22.0}, {1257.0, 777.0}, {320.0, 200.0}, {640.0, 400.0}, {22.0, 777.0}}) {
      const Sampled s = sample_disc(lens, cx, cy, diameter_px);
      const Undistorted plain = undistort(lens, s.cx, s.cy);
      const Undistorted blob = undistort_blob(lens, s.cx, s.cy, s.xx, s.xy, s.yy);
      ASSERT_TRUE(blob.converged);
      const double without_px = 914 * std::hypot(plain.x - s.x, plain.y - s.y);
      const double with_px = 914 * std::hypot(blob.x - s.x, blob.y - s.y);
      EXPECT_LE(with_px, 0.002) << diameter_px << " at " << cx << ", " << cy;
      if (diameter_px == 40.0 && cx != 640.0) {
        EXPECT_GT(without_px, 0.05) << "the test would pass without the term";
      }
    }
  }
}

TEST(Lens, SecondOrderTermRemovesAThirdOfAPixel) {
  const Lens lens{914, 914, 640, 400, {-0.32, 0.07, 0, 0, 0}};
  const Sampled s = sample_disc(lens, 120, 75, 40.0);
  const Undistorted plain = undistort(lens, s.cx, s.cy);
  const Undistorted blob = undistort_blob(lens, s.cx, s.cy, s.xx, s.xy, s.yy);
  EXPECT_GT(914 * std::hypot(plain.x - s.x, plain.y - s.y), 0.35);
  EXPECT_LE(914 * std::hypot(blob.x - s.x, blob.y - s.y), 0.002);
}

TEST(Lens, SecondOrderTermTakesSkewedMomentsAndDifferentFocalLengths) {
  // Two points apart along a slanted line: the mean of the inverse is known exactly, and the second
  // differences must agree with it to fourth order.
  const Lens lens{800, 1100, 600, 420, {-0.3, 0.1, 0.002, -0.003, -0.01}};
  const double x = 180, y = 110;
  const auto error_px = [&](double dx, double dy) {
    const Undistorted a = undistort(lens, x + dx, y + dy), b = undistort(lens, x - dx, y - dy);
    const Undistorted blob = undistort_blob(lens, x, y, dx * dx, dx * dy, dy * dy);
    return std::hypot(800 * (0.5 * (a.x + b.x) - blob.x), 1100 * (0.5 * (a.y + b.y) - blob.y));
  };
  for (const auto& [dx, dy] : {std::pair{8.0, 0.0}, {0.0, 8.0}, {6.0, 5.0}, {6.0, -5.0}}) {
    const double at_full = error_px(dx, dy), at_half = error_px(0.5 * dx, 0.5 * dy);
    EXPECT_LT(at_full, 1e-3);
    EXPECT_NEAR(at_full / at_half, 16.0, 1.0) << "the rest is of fourth order";
  }
}

}  // namespace
}  // namespace glint::gpu
