// SPDX-License-Identifier: MIT
// Every detector gives what the reference gives, on any image.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <string>
#include <utility>
#include <vector>

#include "tests/gpu/compare_blobs.hpp"
#include "tests/gpu/detector_cases.hpp"
#include "tests/gpu/test_images.hpp"

namespace glint::gpu::testing {
namespace {

class DetectorParity : public ::testing::TestWithParam<DetectorCase> {};

/// Room for every blob that these images can have.
DetectorOptions roomy() {
  DetectorOptions options;
  options.max_blobs_per_camera = 32768;
  return options;
}

TEST_P(DetectorParity, Shapes) { expect_equal_to_reference(GetParam(), shape_images(97, 61), roomy()); }

TEST_P(DetectorParity, ShapesOfWholeTiles) {
  // Multiples of every tile, vector and group.
  expect_equal_to_reference(GetParam(), shape_images(256, 64), roomy());
}

TEST_P(DetectorParity, LargerShapes) {
  std::vector<TestImage> images = shape_images(331, 203);
  // Half of them are enough at this size; which half does not matter.
  for (std::size_t i = 0; i < images.size() / 2; ++i) std::swap(images[i], images[2 * i]);
  images.resize(images.size() / 2);
  expect_equal_to_reference(GetParam(), images, roomy());
}

TEST_P(DetectorParity, NoiseOfAnyDensity) {
  std::vector<TestImage> images;
  for (const double density : {0.01, 0.05, 0.12, 0.18, 0.30, 0.40, 0.50, 0.60, 0.90, 0.99}) {
    images.push_back(noise_image(641, 479, density, 11 + static_cast<std::uint32_t>(100 * density)));
  }
  expect_equal_to_reference(GetParam(), images, roomy());
}

TEST_P(DetectorParity, NoiseInAllTilesOfTheFusedStep) {
  std::vector<TestImage> images;  // 2000 tiles: no more go through the fused step on a CPU driver
  for (const double density : {0.05, 0.12, 0.18, 0.25, 0.30, 0.40, 0.50}) {
    images.push_back(noise_image(640, 400, density, 71 + static_cast<std::uint32_t>(100 * density)));
  }
  expect_equal_to_reference(GetParam(), images, roomy());
}

TEST_P(DetectorParity, NoiseInImagesOfAllSizesAtOnce) {
  constexpr std::uint32_t kSizes[][2] = {{1, 1},   {1, 7},    {7, 1},   {15, 9},  {16, 8},  {17, 9},
                                         {31, 33}, {64, 48},  {63, 49}, {65, 47}, {255, 3}, {256, 2},
                                         {257, 5}, {3, 257},  {2, 300}, {128, 1}, {1, 100}, {129, 97},
                                         {320, 8}, {323, 17}, {512, 30}};
  for (const double density : {0.05, 0.35, 0.7}) {
    std::vector<TestImage> images;
    for (const auto& size : kSizes) {
      images.push_back(
          noise_image(size[0], size[1], density, 31 + static_cast<std::uint32_t>(images.size())));
    }
    expect_equal_to_reference(GetParam(), images, roomy());
  }
}

TEST_P(DetectorParity, SmallestImages) {
  std::vector<TestImage> images = {all_white(1, 1),  all_black(1, 1),  all_white(1, 7),
                                   all_white(7, 1),  all_white(15, 9), all_white(16, 8),
                                   all_white(17, 9), dot_grid(17, 9),  dot_grid(1, 7)};
  expect_equal_to_reference(GetParam(), images, roomy());
}

TEST_P(DetectorParity, OnePixelOnEveryPlaceOfTheBorder) {
  // 33x17: tile borders inside, odd ends.
  std::vector<TestImage> images;
  const auto flush = [&] {
    if (!images.empty()) expect_equal_to_reference(GetParam(), images, roomy());
    images.clear();
  };
  for (const std::uint32_t x : {0u, 1u, 7u, 8u, 15u, 16u, 31u, 32u}) {
    for (const std::uint32_t y : {0u, 7u, 8u, 16u}) {
      images.push_back(image_from_mask(
          "pixel at " + std::to_string(x) + "," + std::to_string(y), 33, 17,
          [&](std::uint32_t px, std::uint32_t py) { return px == x && py == y; }, 17 * x + y));
    }
  }
  ASSERT_EQ(images.size(), kMaxCameras);
  flush();
}

TEST_P(DetectorParity, FourRealisticCameras) {
  const std::vector<TestImage> images = {
      soft_spots(1280, 800, 20, 40.0, 1), soft_spots(1280, 800, 200, 40.0, 2),
      soft_spots(1280, 800, 3, 300.0, 3),
      image_from_mask(
          "random limit", 1280, 800,
          [](std::uint32_t x, std::uint32_t y) {
            return std::hypot(x % 160 - 80.0, y % 100 - 50.0) < 1.0 + x / 60.0;
          },
          9)};
  expect_equal_to_reference(GetParam(), images, roomy());
}

TEST_P(DetectorParity, MissingFramesGiveNoBlobs) {
  std::vector<TestImage> images = {noise_image(65, 33, 0.3, 1), noise_image(40, 20, 0.3, 2),
                                   noise_image(65, 33, 0.3, 3), all_white(30, 30)};
  images[0].pixels.clear();
  images[2].pixels.clear();
  expect_equal_to_reference(GetParam(), images, roomy());
  for (TestImage& image : images) image.pixels.clear();
  expect_equal_to_reference(GetParam(), images, roomy());
}

TEST_P(DetectorParity, AreaFilter) {
  DetectorOptions options = roomy();
  for (const auto& [least, most] : {std::pair{2u, 0xffffffffu}, {1u, 3u}, {4u, 4u}, {5u, 30u}}) {
    options.min_area_px = least;
    options.max_area_px = most;
    const std::vector<TestImage> images = {noise_image(201, 103, 0.25, 5), noise_image(203, 99, 0.1, 6),
                                           all_white(33, 33), soft_spots(300, 200, 20, 15.0, 7)};
    expect_equal_to_reference(GetParam(), images, options);
  }
}

TEST_P(DetectorParity, LensThatFoldsOver) {
  // Without a k2 to hold it, k1 = -0.32 turns back at 0.68 of the z = 1 plane: 622 px from the centre.
  // Spots well inside and well outside of that.
  const TestImage image = image_from_mask(
      "spots", 1280, 800,
      [](std::uint32_t x, std::uint32_t y) {
        const double r = std::hypot(x - 640.0, y - 400.0);
        return (r < 580.0 || r > 680.0) && std::hypot(x % 80 - 40.0, y % 80 - 40.0) < 6.0;
      },
      3);
  const std::vector<CameraFormat> formats = {{1280, 800, {914, 914, 640, 400, {-0.32, 0, 0, 0, 0}}}};
  FrameMemory memory({&image, 1}, GetParam().layout);
  const auto reference = make_reference_detector(formats, roomy());
  const auto tested = GetParam().make(formats, roomy());
  if (GetParam().adopt) tested->adopt_frame_memory(memory.memory());
  set_limits(*reference, {&image, 1});
  set_limits(*tested, {&image, 1});
  const BlobBatch expected = detect(*reference, memory.views()), actual = detect(*tested, memory.views());
  EXPECT_TRUE(same_blobs(expected.cameras[0], actual.cameras[0], formats[0].lens));
  const auto folded = [](const BlobRecord& b) { return (b.flags & shaders::kBlobNotInvertible) != 0; };
  const auto count = std::count_if(actual.cameras[0].blobs.begin(), actual.cameras[0].blobs.end(), folded);
  EXPECT_GT(count, 0);
  EXPECT_LT(count, static_cast<long>(actual.cameras[0].blobs.size()));
}

INSTANTIATE_TEST_SUITE_P(Detectors, DetectorParity, ::testing::ValuesIn(detector_cases()), case_name);

TEST(VulkanDevices, ThereIsOneToTest) {
  std::string problem;
  for (const DeviceInfo& device : list_devices(&problem)) {
    if (device.usable) return;
    problem += device.name + ": " + device.why_not_usable + "\n";
  }
  const char* required = std::getenv("GLINT_REQUIRE");
  ASSERT_TRUE(required == nullptr || std::string(required).find("gpu") == std::string::npos)
      << "GLINT_REQUIRE asks for a GPU: " << problem;
  GTEST_SKIP() << "SKIPPED: no Vulkan device, only the CPU detectors were tested: " << problem;
}

}  // namespace
}  // namespace glint::gpu::testing
