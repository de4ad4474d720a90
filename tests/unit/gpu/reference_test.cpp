// SPDX-License-Identifier: MIT
// The reference detector against numbers worked out by hand: it defines what correct means for the others.
#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "gpu/background.hpp"
#include "gpu/detector.hpp"
#include "gpu/lens.hpp"

namespace glint::gpu {
namespace {

std::vector<BlobRecord> blobs_of(const std::vector<std::uint8_t>& pixels, std::uint32_t width,
                                 std::uint32_t height, const std::vector<std::uint8_t>& limit,
                                 const Lens& lens = {}, const DetectorOptions& options = {}) {
  const CameraFormat format{width, height, lens};
  const auto detector = make_reference_detector({&format, 1}, options);
  detector->set_limit(0, limit);
  const ImageView image{pixels.data(), width, height, width, PixelFormat::Grey8};
  BlobBatch batch;
  EXPECT_EQ(detector->submit({&image, 1}), RunStatus::Ok);
  EXPECT_EQ(detector->collect(batch), RunStatus::Ok);
  return {batch.cameras[0].blobs.begin(), batch.cameras[0].blobs.end()};
}

TEST(Reference, SumsOneBlob) {
  //            limit 10 everywhere but 20 at (3, 1)
  const std::vector<std::uint8_t> pixels = {0, 0,  0,  0,  0,  0,  //
                                            0, 0,  12, 50, 0,  0,  //
                                            0, 14, 0,  0,  10, 0,  //
                                            0, 0,  0,  0,  0,  0};
  std::vector<std::uint8_t> limit(24, 10);
  limit[6 + 3] = 20;
  const auto blobs = blobs_of(pixels, 6, 4, limit);
  ASSERT_EQ(blobs.size(), 1u);  // (1, 2) touches (2, 1) by its corner; 10 is not above 10
  const BlobRecord& b = blobs[0];
  EXPECT_EQ(b.camera, 0u);
  EXPECT_EQ(b.area_px, 3u);
  EXPECT_EQ(b.sum, 12u + 50u + 14u);
  EXPECT_EQ(b.weight, 2u + 30u + 4u);
  EXPECT_EQ(b.peak, 50u);
  EXPECT_EQ(b.x_min_px, 1u);
  EXPECT_EQ(b.y_min_px, 1u);
  EXPECT_EQ(b.x_max_px, 3u);
  EXPECT_EQ(b.y_max_px, 2u);
  EXPECT_EQ(b.flags, 0u);
  const double x = (2 * 2 + 30 * 3 + 4 * 1) / 36.0, y = (2 * 1 + 30 * 1 + 4 * 2) / 36.0;
  EXPECT_FLOAT_EQ(b.x_px, static_cast<float>(x));
  EXPECT_FLOAT_EQ(b.y_px, static_cast<float>(y));
  EXPECT_NEAR(b.var_xx_px2, (2 * 4 + 30 * 9 + 4 * 1) / 36.0 - x * x, 1e-6);
  EXPECT_NEAR(b.var_xy_px2, (2 * 2 + 30 * 3 + 4 * 2) / 36.0 - x * y, 1e-6);
  EXPECT_NEAR(b.var_yy_px2, (2 * 1 + 30 * 1 + 4 * 4) / 36.0 - y * y, 1e-6);
  // Without distortion, with the default lens: the centroid itself.
  EXPECT_FLOAT_EQ(b.x_undist, b.x_px);
  EXPECT_FLOAT_EQ(b.y_undist, b.y_px);
}

TEST(Reference, FlagsBorderAndSaturation) {
  for (std::uint32_t y = 0; y < 5; ++y) {
    for (std::uint32_t x = 0; x < 7; ++x) {
      std::vector<std::uint8_t> pixels(35, 0);
      pixels[y * 7 + x] = (x + y) % 2 == 0 ? 255 : 254;
      const auto blobs = blobs_of(pixels, 7, 5, flat_limit(7, 5, 40));
      ASSERT_EQ(blobs.size(), 1u);
      const bool border = x == 0 || y == 0 || x == 6 || y == 4;
      EXPECT_EQ((blobs[0].flags & shaders::kBlobOnBorder) != 0, border);
      EXPECT_EQ((blobs[0].flags & shaders::kBlobSaturated) != 0, (x + y) % 2 == 0);
    }
  }
}

TEST(Reference, SortsAndFilters) {
  const std::vector<std::uint8_t> pixels = {0, 9, 0, 0, 9, 9,  //
                                            0, 0, 0, 0, 0, 0,  //
                                            9, 9, 9, 0, 9, 0};
  const auto all = blobs_of(pixels, 6, 3, flat_limit(6, 3, 5));
  ASSERT_EQ(all.size(), 4u);
  EXPECT_EQ(all[0].x_min_px, 1u);
  EXPECT_EQ(all[1].x_min_px, 4u);
  EXPECT_EQ(all[2].x_min_px, 0u);
  EXPECT_EQ(all[3].x_min_px, 4u);
  DetectorOptions options;
  options.min_area_px = 2;
  options.max_area_px = 2;
  const auto two = blobs_of(pixels, 6, 3, flat_limit(6, 3, 5), {}, options);
  ASSERT_EQ(two.size(), 1u);
  EXPECT_EQ(two[0].area_px, 2u);
}

TEST(Reference, UndistortsWithTheSecondOrderTerm) {
  const Lens lens{914, 914, 640, 400, {-0.32, 0.12, 0.0006, -0.0004, -0.015}};
  std::vector<std::uint8_t> pixels(1280 * 800, 0);
  double mean_x = 0, mean_y = 0, n = 0;
  for (std::uint32_t y = 0; y < 800; ++y) {
    for (std::uint32_t x = 0; x < 1280; ++x) {
      if (std::hypot(x - 1255.0, y - 775.0) > 20.0) continue;
      pixels[y * 1280 + x] = 140;
      const Undistorted u = undistort(lens, x, y);
      mean_x += u.x, mean_y += u.y, n += 1;
    }
  }
  const auto blobs = blobs_of(pixels, 1280, 800, flat_limit(1280, 800, 40), lens);
  ASSERT_EQ(blobs.size(), 1u);
  EXPECT_NEAR(blobs[0].x_undist, mean_x / n, 0.002 / 914);
  EXPECT_NEAR(blobs[0].y_undist, mean_y / n, 0.002 / 914);
  const Undistorted centre = undistort(lens, blobs[0].x_px, blobs[0].y_px);
  EXPECT_GT(std::hypot(centre.x - mean_x / n, centre.y - mean_y / n), 0.05 / 914);
}

TEST(Reference, NothingIsBrightBeforeALimitIsSet) {
  const CameraFormat format{4, 4, {}};
  for (const auto& detector :
       {make_reference_detector({&format, 1}, {}), make_cpu_detector({&format, 1}, {})}) {
    const std::vector<std::uint8_t> pixels(16, 255);
    const ImageView image{pixels.data(), 4, 4, 4, PixelFormat::Grey8};
    BlobBatch batch;
    ASSERT_EQ(detector->submit({&image, 1}), RunStatus::Ok);
    ASSERT_EQ(detector->collect(batch), RunStatus::Ok);
    EXPECT_EQ(batch.cameras[0].found, 0u);
  }
}

TEST(CpuDetectors, RefuseOptionsThatMakeNoSense) {
  const CameraFormat format{4, 4, {}};
  const auto refused = [&](auto change) {
    DetectorOptions options;
    change(options);
    EXPECT_THROW(make_reference_detector({&format, 1}, options), Error);
    EXPECT_THROW(make_cpu_detector({&format, 1}, options), Error);
  };
  refused([](DetectorOptions& o) { o.threads = 0; });
  refused([](DetectorOptions& o) { o.depth = 0; });
  refused([](DetectorOptions& o) { o.max_blobs_per_camera = 0; });
  refused([](DetectorOptions& o) { o.min_area_px = 5, o.max_area_px = 4; });
  const CameraFormat no_focal_length{4, 4, {0, 0, 0, 0, {}}}, not_finite{4, 4, {1, 1, std::nan(""), 0, {}}};
  EXPECT_THROW(make_cpu_detector({&no_focal_length, 1}, {}), Error);
  EXPECT_THROW(make_cpu_detector({&not_finite, 1}, {}), Error);
}

}  // namespace
}  // namespace glint::gpu
