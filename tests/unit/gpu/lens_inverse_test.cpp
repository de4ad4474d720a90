// SPDX-License-Identifier: MIT
// The CPU detector's way of undistorting blobs against the plain one, for lenses tame and wild.
#include "gpu/cpu/lens_inverse.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <string>
#include <vector>

namespace glint::gpu {
namespace {

struct NamedLens {
  const char* name;
  std::array<double, 5> k;
  bool always_inverts;  // everywhere in the image
};

const std::vector<NamedLens>& lenses() {
  static const std::vector<NamedLens> all = {
      {"none", {0, 0, 0, 0, 0}, true},
      {"wide", {-0.32, 0.12, 0.0006, -0.0004, -0.015}, true},
      {"mild_barrel", {-0.1, 0.01, 0, 0, 0}, true},
      {"pincushion", {0.2, 0.05, 0.001, 0.002, 0.01}, true},
      {"tangential", {-0.05, 0.0, 0.01, -0.015, 0.0}, true},
      {"folds_in_the_image", {-0.6, 0.05, 0.0, 0.0, 0.0}, false},
      {"folds_near_the_centre", {-3.0, 0.0, 0.001, 0.0, 0.0}, false},
      {"folds_and_comes_back", {-0.9, 0.6, 0.0, 0.0, 0.0}, false},
  };
  return all;
}

TEST(LensInverse, DoesAsThePlainWayDoes) {
  for (const NamedLens& named : lenses()) {
    for (const double focal_px : {400.0, 914.0, -914.0, 3000.0}) {
      const CameraFormat format{1280, 800, {focal_px, 1.01 * focal_px, 655.0, 391.0, named.k}};
      const LensInverse inverse(format);
      std::size_t inverted = 0, points = 0;
      for (double y = -0.5; y <= 799.5; y += 13.3) {
        for (double x = -0.5; x <= 1279.5; x += 17.7) {
          const double xx = 30.0 + 0.1 * x, xy = 5.0 - 0.02 * y, yy = 20.0 + 0.05 * y;
          const Undistorted expected = undistort_blob(format.lens, x, y, xx, xy, yy);
          const Undistorted actual = inverse.undistort_blob(x, y, xx, xy, yy);
          const std::string where = std::string(named.name) + " " + std::to_string(focal_px) + " at " +
                                    std::to_string(x) + " " + std::to_string(y);
          ASSERT_EQ(actual.converged, expected.converged) << where;
          ++points;
          inverted += expected.converged ? 1u : 0u;
          if (!expected.converged) continue;
          ASSERT_NEAR(actual.x * focal_px, expected.x * focal_px, 1e-6) << where;
          ASSERT_NEAR(actual.y * focal_px, expected.y * focal_px, 1e-6) << where;
        }
      }
      if (named.always_inverts && std::abs(focal_px) > 500.0) {
        EXPECT_EQ(inverted, points) << named.name;
      }
    }
  }
}

TEST(LensInverse, SaysNoWherePixelsAreNoNumbers) {
  const LensInverse inverse({640, 480, {500, 500, 320, 240, {-0.2, 0, 0, 0, 0}}});
  EXPECT_FALSE(inverse.undistort_blob(std::nan(""), 3.0, 1.0, 0.0, 1.0).converged);
  EXPECT_FALSE(inverse.undistort_blob(1.0, INFINITY, 1.0, 0.0, 1.0).converged);
}

}  // namespace
}  // namespace glint::gpu
