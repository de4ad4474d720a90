// SPDX-License-Identifier: MIT
// Discs that touch, overlap, are clipped or partly hidden are found to within what their noise allows, and
// the covariances say how well.
#include "host/resolve/disc_fit.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <functional>
#include <numbers>
#include <vector>

#include <Eigen/LU>

#include "tests/support/allocations.hpp"
#include "tests/unit/resolve/drawn_discs.hpp"

namespace glint {
namespace {

using namespace testing;

constexpr double kDark_grey = 10.0, kStart_sd_px = 0.4;

struct Result {
  int cases = 0, failed = 0;
  double rms_px = 0.0, bound_px = 0.0, median_px = 0.0, worst_px = 0.0, nees = 0.0, chi2 = 0.0;
};

using Make =
    std::function<std::vector<TrueDisc>(sim::Random&, double radius_px, const Eigen::Vector2d& middle_px)>;

Eigen::Vector2d any_direction(sim::Random& random) {
  const double angle = random.uniform(0.0, 2.0 * std::numbers::pi);
  return {std::cos(angle), std::sin(angle)};
}

/// Fits discs of 1.5 to 8 px at random phases from starts that are wrong by kStart_sd_px in each direction.
Result fit_many(const char* name, int cases, const Make& make) {
  sim::Random random(21);
  const sim::NormalTable normal;
  const PixelNoise noise;
  DiscFit fit(noise);
  Result result;
  double squares = 0.0, bound = 0.0;
  std::vector<double> errors;
  for (int k = 0; k < cases; ++k) {
    const double radius = random.uniform(1.5, 8.0);
    const auto side = static_cast<std::uint32_t>(5.5 * radius + 16.0);
    const Eigen::Vector2d middle(side / 2.0 + random.uniform(-0.5, 0.5),
                                 side / 2.0 + random.uniform(-0.5, 0.5));
    const std::vector<TrueDisc> discs = make(random, radius, middle);
    const DrawnImage image = draw(side, side, kDark_grey, discs, noise, random, normal);
    std::vector<ExpectedDisc> expected;
    for (const TrueDisc& disc : discs) {
      ExpectedDisc e;
      for (int axis = 0; axis < 2; ++axis)
        e.centre_px[axis] = disc.centre_px[axis] + kStart_sd_px * static_cast<double>(normal.draw(random));
      e.shape_px2 = disc.shape_px2;
      e.distance_m = disc.distance_m;
      expected.push_back(e);
    }
    std::vector<FittedDisc> fitted(expected.size());
    FitQuality quality;
    ++result.cases;
    if (!fit.fit(image.view(), image.box(), expected, fitted, quality)) {
      ++result.failed;
      continue;
    }
    result.chi2 += quality.chi2_per_dof;
    const Eigen::MatrixXd best = smallest_covariance_px2(side, side, kDark_grey, discs, noise);
    for (std::size_t i = 0; i < discs.size(); ++i) {
      const Eigen::Vector2d error = fitted[i].centre_px - discs[i].centre_px;
      errors.push_back(error.norm());
      squares += error.squaredNorm();
      result.nees += error.dot(fitted[i].covariance_px2.inverse() * error);
      const auto at = static_cast<Eigen::Index>(2 * i);
      bound += best(at, at) + best(at + 1, at + 1);
    }
  }
  const auto n = static_cast<double>(errors.size());
  std::sort(errors.begin(), errors.end());
  result.rms_px = std::sqrt(squares / n);
  result.bound_px = std::sqrt(bound / n);
  result.median_px = errors[errors.size() / 2];
  result.worst_px = errors.back();
  result.nees /= n;
  result.chi2 /= result.cases - result.failed;
  std::printf(
      "%-28s %d of %d failed, rms %.4f px, bound %.4f, median %.4f, worst %.3f, NEES %.2f, chi2 %.2f\n", name,
      result.failed, result.cases, result.rms_px, result.bound_px, result.median_px, result.worst_px,
      result.nees, result.chi2);
  return result;
}

void expect_near_bound(const Result& result) {
  EXPECT_EQ(result.failed, 0);
  EXPECT_LT(result.rms_px, 1.35 * result.bound_px);
  EXPECT_LT(result.worst_px, 0.2);
  EXPECT_GT(result.nees, 1.1);
  EXPECT_LT(result.nees, 2.5);
  EXPECT_NEAR(result.chi2, 1.0, 0.1);
}

std::vector<TrueDisc> one(sim::Random& random, double radius_px, const Eigen::Vector2d& middle_px) {
  return {round_disc(middle_px, radius_px, random.uniform(40.0, 200.0))};
}

TEST(DiscFit, AKnownPatternOfTheBackgroundIsNoNoise) {
  constexpr double kRadius_px = 2.0;
  constexpr std::uint32_t kSide_px = 24;
  constexpr int kCases = 200;
  PixelNoise noise;
  noise.fixed_pattern_grey = 0.0;  // here it is in the pixels, whole grey levels of it
  sim::Random random(5);
  const sim::NormalTable normal;
  DiscFit fit{PixelNoise()};
  double known = 0.0, unknown = 0.0, none = 0.0, nees = 0.0;
  for (int k = 0; k < kCases; ++k) {
    const Eigen::Vector2d middle(12.0 + random.uniform(-0.5, 0.5), 12.0 + random.uniform(-0.5, 0.5));
    const std::vector<TrueDisc> discs{round_disc(middle, kRadius_px, 60.0)};
    DrawnImage image = draw(kSide_px, kSide_px, kDark_grey, discs, noise, random, normal);
    ExpectedDisc expected;
    expected.centre_px = middle + Eigen::Vector2d(0.2, -0.1);
    expected.shape_px2 = discs[0].shape_px2;
    FittedDisc fitted;
    FitQuality quality;
    const auto squared_error = [&](const std::uint16_t* background) {
      gpu::ImageView view = image.view();
      view.background = background;
      EXPECT_TRUE(fit.fit(view, image.box(), {&expected, 1}, {&fitted, 1}, quality)) << "case " << k;
      return (fitted.centre_px - middle).squaredNorm();
    };
    std::vector<std::uint16_t> background(image.pixels.size(), 0);
    none += squared_error(background.data());
    for (std::size_t i = 0; i < background.size(); ++i) {
      const auto extra = static_cast<std::uint8_t>(random.uniform(0.0, 5.0));
      image.pixels[i] = static_cast<std::uint8_t>(image.pixels[i] + extra);
      background[i] =
          static_cast<std::uint16_t>(gpu::kBackgroundStepsPerGrey * (3u + extra));  // it may have drifted
    }
    known += squared_error(background.data());
    EXPECT_NEAR(quality.background_grey, kDark_grey - 3.0, 0.5);
    const Eigen::Vector2d error = fitted.centre_px - middle;
    nees += error.dot(fitted.covariance_px2.inverse() * error) / kCases;
    unknown += squared_error(nullptr);
  }
  std::printf("rms without pattern %.4f px, known %.4f, unknown %.4f; NEES of the known %.2f\n",
              std::sqrt(none / kCases), std::sqrt(known / kCases), std::sqrt(unknown / kCases), nees);
  EXPECT_LT(known, 1.1 * none);
  EXPECT_GT(unknown, 1.5 * none);
  EXPECT_NEAR(nees, 2.0, 0.5);
}

Make two(double apart_radii) {
  return [apart_radii](sim::Random& random, double radius_px, const Eigen::Vector2d& middle_px) {
    const Eigen::Vector2d half = 0.5 * apart_radii * radius_px * any_direction(random);
    const double grey = random.uniform(40.0, 200.0);
    return std::vector{round_disc(middle_px - half, radius_px, grey, 2.0),
                       round_disc(middle_px + half, radius_px, grey * random.uniform(0.9, 1.1), 2.1)};
  };
}

Make hidden_to(double share) {
  return [share](sim::Random& random, double radius_px, const Eigen::Vector2d& middle_px) {
    std::vector<TrueDisc> discs = one(random, radius_px, middle_px);
    discs[0].edge_normal = any_direction(random);
    discs[0].edge_px = radius_px * edge_that_hides(share);
    return discs;
  };
}

TEST(DiscFit, OneDisc) { expect_near_bound(fit_many("one disc", 200, one)); }

TEST(DiscFit, OneEllipse) {
  expect_near_bound(fit_many("one ellipse, axes 1.3 : 1", 200,
                             [](sim::Random& random, double radius_px, const Eigen::Vector2d& middle_px) {
                               std::vector<TrueDisc> discs = one(random, radius_px, middle_px);
                               const Eigen::Vector2d along = any_direction(random);
                               discs[0].shape_px2 = radius_px * radius_px *
                                                    (Eigen::Matrix2d::Identity() / 1.3 +
                                                     (1.3 - 1.0 / 1.3) * along * along.transpose());
                               return discs;
                             }));
}

TEST(DiscFit, TwoDiscsComeApart) {
  for (const double apart : {1.2, 1.5, 1.8, 2.0, 2.3}) {
    char name[40];
    std::snprintf(name, sizeof name, "two, %.1f radii apart", apart);
    expect_near_bound(fit_many(name, 200, two(apart)));
  }
}

TEST(DiscFit, ThreeDiscs) {
  expect_near_bound(fit_many("three, 1.5 radii apart", 200,
                             [](sim::Random& random, double radius_px, const Eigen::Vector2d& middle_px) {
                               const Eigen::Vector2d a = any_direction(random);
                               const double bend = random.uniform(-1.2, 1.2);
                               const Eigen::Vector2d b(std::cos(bend) * a.x() - std::sin(bend) * a.y(),
                                                       std::sin(bend) * a.x() + std::cos(bend) * a.y());
                               const double grey = random.uniform(40.0, 180.0);
                               return std::vector{
                                   round_disc(middle_px - 1.5 * radius_px * a, radius_px, grey, 2.0),
                                   round_disc(middle_px, radius_px, grey * random.uniform(0.9, 1.1), 2.1),
                                   round_disc(middle_px + 1.5 * radius_px * b, radius_px,
                                              grey * random.uniform(0.9, 1.1), 2.2)};
                             }));
}

TEST(DiscFit, ClippedDiscsAreFoundByTheirEdges) {
  expect_near_bound(fit_many(
      "one clipped", 200, [](sim::Random& random, double radius_px, const Eigen::Vector2d& middle_px) {
        return std::vector{round_disc(middle_px, radius_px, random.uniform(260.0, 500.0))};
      }));
}

TEST(DiscFit, WhatIsHiddenDoesNotPull) {
  for (const double share : {0.1, 0.2, 0.4, 0.6}) {
    char name[40];
    std::snprintf(name, sizeof name, "one, %.0f %% hidden", 100.0 * share);
    const Result result = fit_many(name, 200, hidden_to(share));
    // The bound knows where the edge lies, the fit does not; the worst are small, dim discs.
    EXPECT_LT(result.median_px, 2.0 * result.bound_px);
    EXPECT_LT(result.failed, share < 0.3 ? 3 : 30);
    EXPECT_GT(result.nees, 0.3);
    EXPECT_LT(result.nees, 4.0);
  }
}

struct Still {
  std::vector<TrueDisc> discs{round_disc({12.3, 12.1}, 4.0, 120.0, 2.0),
                              round_disc({18.2, 13.1}, 4.0, 110.0, 2.1)};
  DrawnImage image;
  std::vector<ExpectedDisc> expected{2};
  std::vector<FittedDisc> fitted{2};
  FitQuality quality;
  DiscFit fit{PixelNoise{}};
  Still() {
    sim::Random random(3);
    image = draw(31, 25, kDark_grey, discs, PixelNoise{}, random, sim::NormalTable{});
    for (std::size_t i = 0; i < 2; ++i) {
      expected[i].centre_px = discs[i].centre_px;
      expected[i].shape_px2 = discs[i].shape_px2;
      expected[i].distance_m = discs[i].distance_m;
    }
  }
  bool run() { return fit.fit(image.view(), image.box(), expected, fitted, quality); }
};

TEST(DiscFit, ResultDoesNotLeanTowardsTheStart) {
  Still still;
  ASSERT_TRUE(still.run());
  const std::vector<FittedDisc> first = still.fitted;
  for (const Eigen::Vector2d& shift :
       {Eigen::Vector2d(0.8, 0.0), Eigen::Vector2d(-0.6, 0.6), Eigen::Vector2d(0.0, -0.8)}) {
    for (std::size_t i = 0; i < 2; ++i) still.expected[i].centre_px = still.discs[i].centre_px + shift;
    ASSERT_TRUE(still.run());
    for (std::size_t i = 0; i < 2; ++i)
      EXPECT_LT((still.fitted[i].centre_px - first[i].centre_px).norm(), 0.006);
  }
}

TEST(DiscFit, OrderOfTheExpectedDiscsDoesNotMatter) {
  Still still;
  ASSERT_TRUE(still.run());
  const std::vector<FittedDisc> first = still.fitted;
  std::swap(still.expected[0], still.expected[1]);
  ASSERT_TRUE(still.run());
  EXPECT_EQ(still.fitted[0].centre_px, first[1].centre_px);
  EXPECT_EQ(still.fitted[1].centre_px, first[0].centre_px);
}

TEST(DiscFit, SaysWhenItCannotTell) {
  Still still;
  still.expected[1].centre_px = still.expected[0].centre_px;  // one disc asked for twice
  EXPECT_FALSE(still.run());
  still = Still();
  std::fill(still.image.pixels.begin(), still.image.pixels.end(), std::uint8_t{10});  // nothing there
  EXPECT_FALSE(still.run());
  still.expected[0].centre_px = {400.0, 400.0};  // beyond the image
  EXPECT_FALSE(still.run());
  EXPECT_FALSE(still.fit.fit(still.image.view(), PixelBox{40, 40, 60, 60}, still.expected, still.fitted,
                             still.quality));
  EXPECT_FALSE(still.fit.fit({}, still.image.box(), still.expected, still.fitted, still.quality));
}

TEST(DiscFit, DoesNotAllocate) {
  Still still;
  const std::size_t before = allocations();
  EXPECT_GT(before, 0u) << "the counter does not count";
  const bool good = still.run();
  EXPECT_EQ(allocations() - before, 0u);
  EXPECT_TRUE(good);
}

}  // namespace
}  // namespace glint
