// SPDX-License-Identifier: MIT
// What is tabulated of cut discs is what an integration over the blurred disc gives, and a blob's moments
// give the radius of its disc.
#include "host/resolve/cut_disc.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <memory>
#include <numbers>
#include <span>
#include <vector>

#include "host/resolve/whole_disc.hpp"
#include "tests/unit/resolve/drawn_discs.hpp"

namespace glint {
namespace {

using namespace testing;

constexpr double kBlur_px = 0.6;
constexpr double kSmallest_px = 0.6, kLargest_px = 30.0, kRadiusStep = 1.07;  // off the table's nodes, mostly
constexpr double kLowest = 0.02, kHighest = 0.9, kLimitStep = 0.022;
constexpr double kTolerance = 0.02;

/// In fine rings: a polar grid, all of whose angles are alike.
CutDisc integrated(const DiscProfile& profile, double limit) {
  constexpr int kRings = 4000;
  const double step = static_cast<double>(profile.reach_px()) / kRings;
  CutDisc sum;
  double second = 0.0;
  for (int i = 0; i < kRings; ++i) {
    const double r = step * (i + 0.5), ring = 2.0 * std::numbers::pi * r * step;
    const double above = static_cast<double>(profile.at(static_cast<float>(r)).share) - limit;
    if (above <= 0.0) continue;
    sum.area_px2 += ring;
    sum.light_px2 += above * ring;
    second += above * ring * 0.5 * r * r;  // the mean of x^2 around a ring
  }
  if (sum.light_px2 > 0.0) sum.second_moment_px2 = second / sum.light_px2;
  return sum;
}

struct Worst {
  double area = 0.0, light = 0.0, moment = 0.0;
  void note(double off_area, double off_light, double off_moment) {
    area = std::max(area, std::abs(off_area));
    light = std::max(light, std::abs(off_light));
    moment = std::max(moment, std::abs(off_moment));
  }
};

/// Compares table and integral for discs from `from_px` to `to_px`.
void expect_as_integrated(double from_px, double to_px) {
  // With less light than that the disc is a few pixels barely above the limit: then what counts is that
  // little is said to be left, and how little is bounded in pixels.
  constexpr double kLittleLight_px2 = 0.4;
  constexpr double kArea_px2 = 0.35, kLight_px2 = 0.012, kMoment_px2 = 0.02;
  const DiscProfiles profiles(kBlur_px);
  const CutDiscs table(profiles);
  Worst share, absolute;
  for (double radius = from_px; radius <= to_px; radius *= kRadiusStep) {
    const DiscProfile profile = profiles.of(radius);
    const double middle = static_cast<double>(profile.at(0.0f).share);
    for (double limit = kLowest; limit <= kHighest && limit < middle; limit += kLimitStep) {
      SCOPED_TRACE(::testing::Message() << "radius " << radius << " px, limit " << limit);
      const CutDisc want = integrated(profile, limit), found = table.of(radius, limit);
      const double area = found.area_px2 - want.area_px2, light = found.light_px2 - want.light_px2,
                   moment = found.second_moment_px2 - want.second_moment_px2;
      if (want.light_px2 < kLittleLight_px2) {
        absolute.note(area, light, moment);
        EXPECT_LT(std::abs(area), kArea_px2);
        EXPECT_LT(std::abs(light), kLight_px2);
        EXPECT_LT(std::abs(moment), kMoment_px2);
      } else {
        share.note(area / want.area_px2, light / want.light_px2, moment / want.second_moment_px2);
        EXPECT_LT(std::abs(area), kTolerance * want.area_px2);
        EXPECT_LT(std::abs(light), kTolerance * want.light_px2);
        EXPECT_LT(std::abs(moment), kTolerance * want.second_moment_px2);
      }
    }
  }
  std::printf(
      "radius %.1f to %.1f px: area off by %.2f %%, light %.2f %%, moment %.2f %% at worst; where little is "
      "left by %.3f px^2, %.4f, %.4f px^2\n",
      from_px, to_px, 100.0 * share.area, 100.0 * share.light, 100.0 * share.moment, absolute.area,
      absolute.light, absolute.moment);
}

TEST(CutDiscs, AreAsIntegrated) { expect_as_integrated(kSmallest_px, 20.0); }

TEST(CutDiscs, OfLargeDiscsAreAsIntegrated) { expect_as_integrated(20.0, kLargest_px); }

TEST(CutDiscs, NothingIsLeftAboveTheMiddle) {
  const DiscProfiles profiles(kBlur_px);
  const CutDiscs table(profiles);
  for (double radius = kSmallest_px; radius <= kLargest_px; radius *= kRadiusStep) {
    const double middle = static_cast<double>(profiles.of(radius).at(0.0f).share);
    for (const double over : {0.01, 0.03, 0.1, 0.2, 0.5}) {
      if (middle + over > 1.0) continue;
      const CutDisc found = table.of(radius, middle + over);
      EXPECT_EQ(found.area_px2, 0.0) << radius << ' ' << over;
      EXPECT_EQ(found.light_px2, 0.0) << radius << ' ' << over;
      EXPECT_EQ(found.second_moment_px2, 0.0) << radius << ' ' << over;
    }
  }
}

TEST(WholeDisc, RadiusComesBackFromTheMoments) {
  constexpr std::uint32_t kSide = 40;
  constexpr std::uint8_t kDark_grey = 10;
  constexpr int kCount = 12;
  const PixelNoise noise;
  const gpu::CameraFormat format{kSide, kSide, {900.0, 900.0, 20.0, 20.0, {}}};
  const auto detector = gpu::make_reference_detector(std::span(&format, 1), {});
  const auto limit = static_cast<std::uint8_t>(kDark_grey + noise.limit_above_dark_grey);
  detector->set_limit(0, std::vector<std::uint8_t>(kSide * kSide, limit));
  const WholeDiscTest test(noise);
  const sim::NormalTable normal;
  sim::Random random(17);
  for (const double radius : {1.6, 2.0, 2.5, 3.2, 4.0, 5.0, 6.0}) {
    double worst = 0.0;
    for (int i = 0; i < kCount; ++i) {
      const Eigen::Vector2d middle(20.0 + random.uniform(-0.5, 0.5), 20.0 + random.uniform(-0.5, 0.5));
      const TrueDisc disc = round_disc(middle, radius, random.uniform(80.0, 220.0));
      const DrawnImage image = draw(kSide, kSide, kDark_grey, std::span(&disc, 1), noise, random, normal);
      const gpu::ImageView view = image.view();
      gpu::BlobBatch batch;
      ASSERT_EQ(detector->submit(std::span(&view, 1)), gpu::RunStatus::Ok);
      ASSERT_EQ(detector->collect(batch), gpu::RunStatus::Ok);
      ASSERT_EQ(batch.cameras[0].blobs.size(), 1u);
      const gpu::BlobRecord& blob = batch.cameras[0].blobs[0];
      const double moment = 0.5 * static_cast<double>(blob.var_xx_px2 + blob.var_yy_px2);
      const double off = test.radius_px(blob, moment) / radius - 1.0;
      EXPECT_LT(std::abs(off), 0.05) << radius << " px, " << disc.grey << " grey";
      worst = std::max(worst, std::abs(off));
    }
    std::printf("radius %.1f px: comes back to %.1f %% at worst\n", radius, 100.0 * worst);
  }
}

}  // namespace
}  // namespace glint
