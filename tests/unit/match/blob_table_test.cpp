// SPDX-License-Identifier: MIT
// What a blob's record says about its centroid, and finding blobs by place.
#include "host/match/blob_table.hpp"

#include <gtest/gtest.h>

#include <set>

#include "tests/unit/match/scene.hpp"

namespace glint {
namespace {

using namespace testing;

class BlobTableTest : public ::testing::Test {
 protected:
  BlobTableTest()
      : rig_(ring_rig(2)), cameras_(rig_.cameras.begin(), rig_.cameras.end()), table_(cameras_, options_) {}

  const MatchBlob& only(const shaders::BlobRecord& record) {
    const std::vector<shaders::BlobRecord> one{record}, none;
    table_.fill(std::vector<std::span<const shaders::BlobRecord>>{one, none});
    return table_[0];
  }
  shaders::BlobRecord disc(double var_x, double var_y, double var_xy = 0.0) {
    shaders::BlobRecord blob = blob_at(rig_.cameras[0], {700, 300});
    blob.area_px = 12;
    blob.var_xx_px2 = static_cast<float>(var_x);
    blob.var_yy_px2 = static_cast<float>(var_y);
    blob.var_xy_px2 = static_cast<float>(var_xy);
    return blob;
  }

  static constexpr double kBare_px = 0.05;  // of blobs that tell nothing of their pixels
  MatchOptions options_;
  const double bare_ = std::hypot(kBare_px, options_.sigma_px);
  Calibration rig_;
  std::vector<Camera> cameras_;
  BlobTable table_;
};

TEST_F(BlobTableTest, AGoodBlobHasTheNominalCovariance) {
  const MatchBlob& blob = only(disc(1.0, 1.1));
  EXPECT_FALSE(blob.suspect);
  EXPECT_NEAR(blob.sigma_px, bare_, 1e-12);
  EXPECT_NEAR(blob.covariance_px2(0, 0), bare_ * bare_, 1e-12);
  EXPECT_NEAR(blob.pixel.x(), 700, 1e-4);
  EXPECT_NEAR(blob.pixel.y(), 300, 1e-4);
  EXPECT_NEAR(blob.radius_px, std::sqrt(12 / M_PI), 1e-12);
}

// Residuals of half the variance that was expected, of blobs of the first camera.
TEST_F(BlobTableTest, WhatResidualsShowScalesTheNoiseOfTheSameCamerasBlobs) {
  shaders::BlobRecord here = disc(1.0, 1.1);
  here.weight = 400, here.sum = 400 + 12 * 20, here.peak = 70;
  shaders::BlobRecord there = blob_at(rig_.cameras[1], {700, 300});
  const std::vector<shaders::BlobRecord> first{here}, second{there};
  const std::vector<std::span<const shaders::BlobRecord>> both{first, second};
  table_.fill(both);
  const double given = options_.sigma_px * options_.sigma_px;
  const double expected = table_[0].covariance_px2(0, 0) - given, others = table_[1].covariance_px2(0, 0);
  for (int k = 0; k < 10'000; ++k) {
    table_.fill(both);
    table_.learn_noise(0, 0.5 * expected / (table_[0].covariance_px2(0, 0) - given), 1.0);
  }
  table_.fill(both);
  EXPECT_NEAR(table_[0].covariance_px2(0, 0), 0.5 * expected + given, 0.01 * expected);
  EXPECT_EQ(table_[1].covariance_px2(0, 0), others);
}

TEST_F(BlobTableTest, ABlobWithItsPixelsKnowsItsNoise) {
  shaders::BlobRecord dim = disc(1.0, 1.1), bright = disc(1.0, 1.1);
  dim.weight = 400, dim.sum = 400 + 12 * 20, dim.peak = 70;
  bright.weight = 2000, bright.sum = 2000 + 12 * 20, bright.peak = 220;
  const double of_dim = only(dim).sigma_px, of_bright = only(bright).sigma_px;
  EXPECT_LT(of_bright, of_dim);
  EXPECT_LT(of_dim, kBare_px);
  EXPECT_GT(of_bright, options_.sigma_px);
}

TEST_F(BlobTableTest, WhatIsResolvedTakesTheBlobsPlace) {
  const std::vector<shaders::BlobRecord> first{blob_at(rig_.cameras[0], {100, 100}),
                                               blob_at(rig_.cameras[0], {300, 200})},
      second{blob_at(rig_.cameras[1], {500, 500})};
  table_.fill(std::vector<std::span<const shaders::BlobRecord>>{first, second});
  const Eigen::Vector2d centre = table_[1].normalized, off(0.002, 0.0);
  table_.resolve(1, centre - off, 1e-4 * Eigen::Matrix2d::Identity(), 0.0, false);
  table_.resolve(1, centre + off, 4e-4 * Eigen::Matrix2d::Identity(), 0.0, true);
  table_.settle();
  ASSERT_EQ(table_.size(), 4u);
  EXPECT_EQ(table_.begin_of(1), 3u);
  EXPECT_EQ(table_[1].record, 1u);
  EXPECT_EQ(table_[2].record, 1u);
  EXPECT_FALSE(table_[0].resolved);
  EXPECT_FALSE(table_[1].suspect);
  EXPECT_TRUE(table_[2].suspect) << "hidden in part";
  EXPECT_LT((table_[2].normalized - centre - off).norm(), 1e-12);
  EXPECT_NEAR(table_[2].covariance_px2(0, 0), 4e-4 + options_.sigma_px * options_.sigma_px, 1e-12);
  std::size_t found = 0;
  table_.near(0, table_[2].pixel, 0.01, [&](std::uint32_t blob) { found += blob == 2 ? 1 : 0; });
  EXPECT_EQ(found, 1u);
}

TEST_F(BlobTableTest, TwoTouchingDiscsAreUncertainAlongTheirLine) {
  // Radius 1.6, centres 3.4 apart at 30 degrees: each lies 1.7 from the common centroid.
  const double along = 0.64 + 1.7 * 1.7, across = 0.64, c = std::cos(M_PI / 6), s = std::sin(M_PI / 6);
  const MatchBlob& blob =
      only(disc(along * c * c + across * s * s, along * s * s + across * c * c, (along - across) * c * s));
  EXPECT_TRUE(blob.suspect);
  const Eigen::Vector2d axis(c, s), normal(-s, c);
  EXPECT_NEAR(std::sqrt(axis.dot(blob.covariance_px2 * axis)), 1.7, 0.01);
  EXPECT_NEAR(std::sqrt(normal.dot(blob.covariance_px2 * normal)), bare_, 1e-6);
}

TEST_F(BlobTableTest, RaggedSmallBlobsAndUnknownShapesAreNotSuspect) {
  EXPECT_FALSE(only(disc(0.67, 0.25)).suspect) << "3 x 2 pixels";
  shaders::BlobRecord tiny = disc(2.0, 0.0);
  tiny.area_px = 3;
  EXPECT_FALSE(only(tiny).suspect) << "three pixels say nothing";
  shaders::BlobRecord unknown = disc(9.0, 0.0);
  unknown.area_px = 0;
  EXPECT_FALSE(only(unknown).suspect) << "from a list of bare points";
}

TEST_F(BlobTableTest, BorderAndSaturationCostPrecision) {
  shaders::BlobRecord border = disc(1, 1), saturated = disc(1, 1);
  border.flags = shaders::kBlobOnBorder;
  saturated.flags = shaders::kBlobSaturated;
  EXPECT_TRUE(only(border).suspect);
  EXPECT_GT(only(border).sigma_px, 0.5);
  EXPECT_FALSE(only(saturated).suspect);
  EXPECT_NEAR(only(saturated).sigma_px, std::hypot(2 * kBare_px, options_.sigma_px), 1e-9);
}

TEST_F(BlobTableTest, WhatTheLensCannotInvertIsNotUsed) {
  shaders::BlobRecord folded = disc(1, 1);
  folded.flags = shaders::kBlobNotInvertible;
  EXPECT_FALSE(only(folded).usable);
  EXPECT_FALSE(table_.free(0));
  shaders::BlobRecord broken = disc(1, 1);
  broken.x_undist = std::numeric_limits<float>::quiet_NaN();
  EXPECT_FALSE(only(broken).usable);
}

TEST_F(BlobTableTest, CalibrationErrorAddsUp) {
  Calibration rig = ring_rig(1);
  rig.cameras[0].rms_px = 0.4;
  const std::vector<Camera> cameras(rig.cameras.begin(), rig.cameras.end());
  BlobTable table(cameras, options_);
  const std::vector<shaders::BlobRecord> one{blob_at(rig.cameras[0], {100, 100})};
  table.fill(std::vector<std::span<const shaders::BlobRecord>>{one});
  EXPECT_NEAR(table[0].sigma_px, std::sqrt(bare_ * bare_ + 0.4 * 0.4 / 2), 1e-9);
}

TEST_F(BlobTableTest, NearFindsExactlyWhatIsNear) {
  std::mt19937_64 random(21);
  for (std::size_t count : {1u, 3u, 50u, 700u}) {
    std::vector<shaders::BlobRecord> blobs;
    for (std::size_t k = 0; k < count; ++k)
      blobs.push_back(
          blob_at(rig_.cameras[1], {uniform(random, 0, 1279), k % 5 == 0 ? 400 : uniform(random, 0, 799)}));
    const std::vector<shaders::BlobRecord> none;
    table_.fill(std::vector<std::span<const shaders::BlobRecord>>{none, blobs});
    for (std::uint32_t k = 0; k < count; k += 7) table_.claim(k);
    for (int query = 0; query < 50; ++query) {
      const Eigen::Vector2d pixel(uniform(random, -200, 1500), uniform(random, -200, 1000));
      const double radius = uniform(random, 0, 300);
      std::set<std::uint32_t> expected, found;
      for (std::uint32_t k = 0; k < count; ++k)
        if (k % 7 != 0 && (table_[k].pixel - pixel).norm() <= radius) expected.insert(k);
      table_.near(1, pixel, radius, [&](std::uint32_t b) { EXPECT_TRUE(found.insert(b).second); });
      EXPECT_EQ(found, expected);
    }
    table_.near(0, {640, 400}, 1e4, [](std::uint32_t) { FAIL() << "camera 0 has no blobs"; });
  }
}

}  // namespace
}  // namespace glint
