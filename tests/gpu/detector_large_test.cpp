// SPDX-License-Identifier: MIT
// The largest images and the most cameras: sums that must not overflow, and room for everything.
#include <gtest/gtest.h>

#include <vector>

#include "tests/gpu/compare_blobs.hpp"
#include "tests/gpu/detector_cases.hpp"
#include "tests/gpu/test_images.hpp"

namespace glint::gpu::testing {
namespace {

class LargeImages : public ::testing::TestWithParam<DetectorCase> {};

void expect_one_white_blob(const CameraBlobs& camera, std::uint32_t width_px, std::uint32_t height_px) {
  ASSERT_EQ(camera.found, 1u);
  const BlobRecord& blob = camera.blobs[0];
  EXPECT_EQ(blob.area_px, width_px * height_px);
  EXPECT_EQ(blob.sum, 255u * width_px * height_px);
  EXPECT_EQ(blob.weight, 255u * width_px * height_px);
  EXPECT_EQ(blob.peak, 255u);
  EXPECT_EQ(blob.flags & (shaders::kBlobSaturated | shaders::kBlobOnBorder),
            shaders::kBlobSaturated | shaders::kBlobOnBorder);
  EXPECT_NEAR(blob.x_px, 0.5 * (width_px - 1), 0.001);
  EXPECT_NEAR(blob.y_px, 0.5 * (height_px - 1), 0.001);
  // A row of n pixels has the variance (n^2 - 1) / 12.
  EXPECT_NEAR(blob.var_xx_px2, (static_cast<double>(width_px) * width_px - 1.0) / 12.0, 1.4e3);
  EXPECT_NEAR(blob.var_yy_px2, (static_cast<double>(height_px) * height_px - 1.0) / 12.0, 0.8e3);
  EXPECT_NEAR(blob.var_xy_px2, 0.0, 1e3);
}

TEST_P(LargeImages, AllWhite) {
  const std::vector<TestImage> images = {all_white(2592, 2048)};
  FrameMemory memory(images, GetParam().layout);
  const auto detector = GetParam().make(formats_of(images), {});
  if (GetParam().adopt) detector->adopt_frame_memory(memory.memory());
  set_limits(*detector, images);
  expect_one_white_blob(detect(*detector, memory.views()).cameras[0], 2592, 2048);
}

// One blob of 98 304 tiles: more than a shader on a CPU driver can add up. Then it is left out, and said to
// be.
TEST_P(LargeImages, AllWhiteBeyondWhatAShaderMayWalk) {
  const std::vector<TestImage> images = {all_white(4096, 3072)};
  FrameMemory memory(images, GetParam().layout);
  const auto detector = GetParam().make(formats_of(images), {});
  if (GetParam().adopt) detector->adopt_frame_memory(memory.memory());
  set_limits(*detector, images);
  const BlobBatch batch = detect(*detector, memory.views());
  if (GetParam().on_gpu() && batch.cameras[0].overflow) {
    EXPECT_EQ(batch.cameras[0].blobs.size(), 0u);
  } else {
    expect_one_white_blob(batch.cameras[0], 4096, 3072);
  }
}

TEST_P(LargeImages, Noise) {
  DetectorOptions options;
  options.min_area_px = 60;  // so that all that pass have room
  expect_equal_to_reference(GetParam(), std::vector<TestImage>{noise_image(4096, 3072, 0.4, 1)}, options);
}

TEST_P(LargeImages, Spots) {
  expect_equal_to_reference(GetParam(), std::vector<TestImage>{soft_spots(4096, 3072, 100, 400.0, 1)});
}

TEST_P(LargeImages, BottomRightCorner) {
  const TestImage image = image_from_mask(
      "corner", 4096, 4096, [](std::uint32_t x, std::uint32_t y) { return x + y >= 8150; }, 1);
  expect_equal_to_reference(GetParam(), {&image, 1});
}

TEST_P(LargeImages, ThirtyTwoCameras) {
  std::vector<TestImage> images;
  for (std::uint32_t i = 0; i < kMaxCameras; ++i) {
    images.push_back(soft_spots(640 + 3 * i, 400 - 2 * i, 10 + i, 25.0, 50 + i));
  }
  expect_equal_to_reference(GetParam(), images);
}

INSTANTIATE_TEST_SUITE_P(Detectors, LargeImages, ::testing::ValuesIn(one_case_per_device()), case_name);

}  // namespace
}  // namespace glint::gpu::testing
