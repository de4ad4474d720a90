// SPDX-License-Identifier: MIT
// What gpu/detector.hpp promises beside the blobs themselves.
#include <gtest/gtest.h>

#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <map>
#include <sstream>
#include <vector>

#include "tests/gpu/compare_blobs.hpp"
#include "tests/gpu/detector_cases.hpp"
#include "tests/gpu/test_images.hpp"

namespace glint::gpu::testing {
namespace {

class DetectorContract : public ::testing::TestWithParam<DetectorCase> {};

TEST_P(DetectorContract, TooManyBlobsAreCountedAndFlagged) {
  const std::vector<TestImage> images = {dot_grid(201, 101), dot_grid(19, 21), dot_grid(20, 20)};
  const auto formats = formats_of(images);
  DetectorOptions options;
  options.max_blobs_per_camera = 100;
  FrameMemory memory(images, GetParam().layout);
  const auto detector = GetParam().make(formats, options);
  if (GetParam().adopt) detector->adopt_frame_memory(memory.memory());
  set_limits(*detector, images);
  const BlobBatch batch = detect(*detector, memory.views());
  constexpr std::uint32_t kFound[] = {101 * 51, 10 * 11, 100};
  for (std::size_t i = 0; i < images.size(); ++i) {
    const CameraBlobs& camera = batch.cameras[i];
    EXPECT_EQ(camera.overflow, kFound[i] > 100) << i;
    EXPECT_EQ(camera.blobs.size(), 100u) << i;
    if (GetParam().on_gpu()) {  // with overflow a lower bound
      EXPECT_GE(camera.found, 100u) << i;
      EXPECT_LE(camera.found, kFound[i]) << i;
    } else {
      EXPECT_EQ(camera.found, kFound[i]) << i;
    }
    for (const BlobRecord& blob : batch.cameras[i].blobs) {
      ASSERT_EQ(blob.area_px, 1u);
      ASSERT_EQ(blob.x_min_px % 2 + blob.y_min_px % 2, 0u);
      ASSERT_EQ(blob.sum, images[i].pixels[blob.y_min_px * images[i].width_px + blob.x_min_px]);
    }
  }
  // The next frame is right again.
  std::vector<TestImage> next = images;
  for (std::size_t i = 0; i < next.size(); ++i) {
    for (std::size_t p = 0; p < next[i].pixels.size(); ++p) {
      if (p % next[i].width_px < 10 || p % next[i].width_px > 20 || p / next[i].width_px > 12)
        next[i].pixels[p] = 0;
    }
    memory.write(i, next[i]);
  }
  const auto reference = make_reference_detector(formats, options);
  set_limits(*reference, images);
  const BlobBatch expected = detect(*reference, memory.views()), actual = detect(*detector, memory.views());
  for (std::size_t i = 0; i < next.size(); ++i) {
    EXPECT_FALSE(expected.cameras[i].overflow);
    EXPECT_GT(expected.cameras[i].found, 20u);
    EXPECT_TRUE(same_blobs(expected.cameras[i], actual.cameras[i], formats[i].lens)) << i;
  }
}

TEST_P(DetectorContract, HasRoomFor8192BlobsByDefault) {
  const std::vector<TestImage> images = {dot_grid(255, 127)};  // 128 * 64 blobs
  FrameMemory memory(images, GetParam().layout);
  const auto detector = GetParam().make(formats_of(images), {});
  if (GetParam().adopt) detector->adopt_frame_memory(memory.memory());
  set_limits(*detector, images);
  const BlobBatch batch = detect(*detector, memory.views());
  EXPECT_EQ(batch.cameras[0].found, 8192u);
  EXPECT_EQ(batch.cameras[0].blobs.size(), 8192u);
  EXPECT_FALSE(batch.cameras[0].overflow);
}

TEST_P(DetectorContract, FramesDoNotLeakIntoEachOther) {
  // Full, empty, noisy and sparse frames in turn through one detector.
  std::vector<TestImage> shown = {noise_image(161, 90, 0.5, 1), all_black(161, 90),
                                  noise_image(161, 90, 0.1, 2), all_white(161, 90),
                                  soft_spots(161, 90, 5, 20.0, 3)};
  const std::vector<TestImage> cameras(3, shown[0]);
  const auto formats = formats_of(cameras);
  FrameMemory memory(cameras, GetParam().layout);
  const auto detector = GetParam().make(formats, {});
  const auto reference = make_reference_detector(formats, {});
  if (GetParam().adopt) detector->adopt_frame_memory(memory.memory());
  set_limits(*detector, cameras);
  set_limits(*reference, cameras);
  for (std::size_t frame = 0; frame < 20; ++frame) {
    for (std::size_t i = 0; i < cameras.size(); ++i) memory.write(i, shown[(frame * (i + 1)) % shown.size()]);
    std::vector<ImageView> views = memory.views();
    if (frame % 7 == 3) views[1].pixels = nullptr;
    const BlobBatch expected = detect(*reference, views), actual = detect(*detector, views);
    for (std::size_t i = 0; i < cameras.size(); ++i) {
      ASSERT_TRUE(same_blobs(expected.cameras[i], actual.cameras[i], formats[i].lens))
          << frame << ", camera " << i;
    }
  }
}

TEST_P(DetectorContract, TheLimitImageCanBeChanged) {
  std::vector<TestImage> images = {noise_image(90, 40, 0.3, 1)};
  const auto formats = formats_of(images);
  FrameMemory memory(images, GetParam().layout);
  const auto detector = GetParam().make(formats, {});
  const auto reference = make_reference_detector(formats, {});
  if (GetParam().adopt) detector->adopt_frame_memory(memory.memory());
  for (const std::uint32_t limit : {0u, 255u, 100u, 40u}) {
    std::fill(images[0].limit.begin(), images[0].limit.end(), static_cast<std::uint8_t>(limit));
    set_limits(*detector, images);
    set_limits(*reference, images);
    const BlobBatch expected = detect(*reference, memory.views()), actual = detect(*detector, memory.views());
    EXPECT_TRUE(same_blobs(expected.cameras[0], actual.cameras[0], formats[0].lens)) << limit;
    if (limit == 255) {
      EXPECT_EQ(actual.cameras[0].found, 0u);
    }
  }
}

TEST_P(DetectorContract, SetsInFlightComeBackInOrder) {
  const std::vector<TestImage> shown = {noise_image(120, 70, 0.2, 1), noise_image(120, 70, 0.3, 2),
                                        noise_image(120, 70, 0.1, 3), noise_image(120, 70, 0.4, 4)};
  std::vector<TestImage> slots = shown;  // each image has its own memory
  for (TestImage& slot : slots) slot.limit = shown[0].limit;
  FrameMemory memory(slots, GetParam().layout);
  const auto formats = formats_of({slots.data(), 1});
  DetectorOptions options;
  options.depth = 2;
  const auto detector = GetParam().make(formats, options);
  const auto reference = make_reference_detector(formats, options);
  if (GetParam().adopt) detector->adopt_frame_memory(memory.memory());
  set_limits(*detector, {slots.data(), 1});
  set_limits(*reference, {slots.data(), 1});
  const std::vector<ImageView> views = memory.views();
  const auto set = [&](std::size_t n) { return std::span<const ImageView>(&views[n % views.size()], 1); };

  BlobBatch batch;
  EXPECT_EQ(detector->collect(batch), RunStatus::Idle);
  ASSERT_EQ(detector->submit(set(0)), RunStatus::Ok);
  ASSERT_EQ(detector->submit(set(1)), RunStatus::Ok);
  EXPECT_EQ(detector->submit(set(2)), RunStatus::Busy);
  for (std::size_t n = 0; n < 9; ++n) {
    ASSERT_EQ(detector->collect(batch), RunStatus::Ok);
    ASSERT_EQ(detector->submit(set(n + 2)), RunStatus::Ok);  // the batch stays valid over this
    const BlobBatch expected = detect(*reference, set(n));
    ASSERT_TRUE(same_blobs(expected.cameras[0], batch.cameras[0], formats[0].lens)) << n;
  }
  ASSERT_EQ(detector->collect(batch), RunStatus::Ok);
  ASSERT_EQ(detector->collect(batch), RunStatus::Ok);
  EXPECT_EQ(detector->collect(batch), RunStatus::Idle);
}

TEST_P(DetectorContract, SaysWhatItTook) {
  const std::vector<TestImage> images = {soft_spots(200, 100, 5, 20.0, 1)};
  FrameMemory memory(images, GetParam().layout);
  const auto detector = GetParam().make(formats_of(images), {});
  set_limits(*detector, images);
  const BlobBatch batch = detect(*detector, memory.views());
  ASSERT_FALSE(batch.stages.empty());
  for (const StageTime& stage : batch.stages) {
    EXPECT_STRNE(stage.name, "");
    EXPECT_GE(stage.seconds, 0.0);
    EXPECT_LT(stage.seconds, 60.0);
  }
  EXPECT_FALSE(detector->device_name().empty());
}

TEST_P(DetectorContract, UploadAheadChangesNothing) {
  const std::vector<TestImage> images = {noise_image(90, 40, 0.3, 1), noise_image(70, 50, 0.2, 2)};
  const auto formats = formats_of(images);
  FrameMemory memory(images, GetParam().layout);
  const auto detector = GetParam().make(formats, {});
  const auto reference = make_reference_detector(formats, {});
  if (GetParam().adopt) detector->adopt_frame_memory(memory.memory());
  set_limits(*detector, images);
  set_limits(*reference, images);
  for (int round = 0; round < 3; ++round) {
    detector->upload(1, memory.views()[1]);
    if (round == 1) detector->upload(0, memory.views()[0]);
    const BlobBatch expected = detect(*reference, memory.views()), actual = detect(*detector, memory.views());
    for (std::size_t i = 0; i < images.size(); ++i) {
      EXPECT_TRUE(same_blobs(expected.cameras[i], actual.cameras[i], formats[i].lens)) << i;
    }
  }
}

TEST_P(DetectorContract, RefusesImagesOfAnotherSize) {
  const std::vector<TestImage> images = {all_white(32, 16), all_white(20, 10)};
  FrameMemory memory(images, GetParam().layout);
  const auto detector = GetParam().make(formats_of(images), {});
  set_limits(*detector, images);
  const std::vector<ImageView> good = memory.views();
  for (const auto spoil : {+[](ImageView& v) { v.width_px -= 1; }, +[](ImageView& v) { v.height_px += 1; },
                           +[](ImageView& v) { v.stride_bytes = v.width_px - 1; }}) {
    std::vector<ImageView> bad = good;
    spoil(bad[1]);
    EXPECT_EQ(detector->submit(bad), RunStatus::BadImage);
    EXPECT_NE(detector->last_error(), "");
  }
  EXPECT_EQ(detector->submit({good.data(), 1}), RunStatus::BadImage);
  // Nothing was left in flight.
  BlobBatch batch;
  EXPECT_EQ(detector->collect(batch), RunStatus::Idle);
  EXPECT_EQ(detect(*detector, good).cameras[0].found, 1u);
}

TEST_P(DetectorContract, RefusesWhatCannotBeSetUp) {
  const CameraFormat good{32, 16, {}};
  const auto make = [&](const std::vector<CameraFormat>& cameras) { return GetParam().make(cameras, {}); };
  EXPECT_THROW(make({}), Error);
  EXPECT_THROW(make(std::vector<CameraFormat>(kMaxCameras + 1, good)), Error);
  EXPECT_THROW(make({{0, 16, {}}}), Error);
  EXPECT_THROW(make({{8192, 8192, {}}}), Error);
  const auto detector = make({good});
  const std::vector<std::uint8_t> limit(32 * 16, 10);
  EXPECT_THROW(detector->set_limit(1, limit), Error);
  EXPECT_THROW(detector->set_limit(0, std::span(limit).first(100)), Error);
  EXPECT_NO_THROW(detector->set_limit(0, limit));
  const ImageView missing{};
  ASSERT_EQ(detector->submit({&missing, 1}), RunStatus::Ok);
  EXPECT_THROW(detector->set_limit(0, limit), Error);
  BlobBatch batch;
  ASSERT_EQ(detector->collect(batch), RunStatus::Ok);
  EXPECT_NO_THROW(detector->set_limit(0, limit));
}

TEST_P(DetectorContract, CanBeDroppedWithSetsInFlight) {
  const std::vector<TestImage> images(4, noise_image(641, 479, 0.4, 1));
  FrameMemory memory(images, GetParam().layout);
  for (int round = 0; round < 3; ++round) {
    const auto detector = GetParam().make(formats_of(images), {});
    set_limits(*detector, images);
    ASSERT_EQ(detector->submit(memory.views()), RunStatus::Ok);
  }
}

TEST_P(DetectorContract, LabelsAsScipyDoes) {
  // label_results.txt holds, for each input, one block per structuring element; the tenth is a full 3x3.
  const char* data = std::getenv("GLINT_TEST_DATA");
  const std::filesystem::path folder =
      std::filesystem::path(data == nullptr ? "" : data) / "scipy-label-vectors";
  if (data == nullptr || !std::filesystem::exists(folder))
    GTEST_SKIP() << "SKIPPED: GLINT_TEST_DATA is not set";
  constexpr std::uint32_t kSide = 7, kBlock = kSide * kSide, kStructures = 14, kFull = 9;
  const auto read = [&](const char* name) {
    std::ifstream file(folder / name);
    std::vector<int> numbers;
    for (int n; file >> n;) numbers.push_back(n);
    return numbers;
  };
  const std::vector<int> inputs = read("label_inputs.txt"), results = read("label_results.txt");
  const std::size_t count = inputs.size() / kBlock;
  ASSERT_EQ(count, 3u);
  ASSERT_EQ(results.size(), count * kStructures * kBlock);
  for (std::size_t n = 0; n < count; ++n) {
    TestImage image = all_black(kSide, kSide);
    struct Box {
      std::uint32_t area = 0, x_min = kSide, y_min = kSide, x_max = 0, y_max = 0;
      auto operator<=>(const Box&) const = default;
    };
    std::map<int, Box> expected;
    for (std::uint32_t i = 0; i < kBlock; ++i) {
      image.pixels[i] = inputs[n * kBlock + i] != 0 ? 200 : 0;
      const int label = results[(n * kStructures + kFull) * kBlock + i];
      if (label == 0) continue;
      Box& box = expected[label];
      const std::uint32_t x = i % kSide, y = i / kSide;
      box = {box.area + 1, std::min(box.x_min, x), std::min(box.y_min, y), std::max(box.x_max, x),
             std::max(box.y_max, y)};
    }
    FrameMemory memory({&image, 1}, GetParam().layout);
    const auto detector = GetParam().make(formats_of({&image, 1}), {});
    set_limits(*detector, {&image, 1});
    std::vector<Box> wanted, got;
    for (const auto& [label, box] : expected) wanted.push_back(box);
    const BlobBatch batch = detect(*detector, memory.views());
    for (const BlobRecord& b : batch.cameras[0].blobs) {
      got.push_back({b.area_px, b.x_min_px, b.y_min_px, b.x_max_px, b.y_max_px});
      EXPECT_EQ(b.sum, 200 * b.area_px);
    }
    std::sort(wanted.begin(), wanted.end());
    std::sort(got.begin(), got.end());
    EXPECT_TRUE(wanted == got) << "input " << n << ": " << wanted.size() << " components, found "
                               << got.size();
  }
}

INSTANTIATE_TEST_SUITE_P(Detectors, DetectorContract, ::testing::ValuesIn(detector_cases()), case_name);

}  // namespace
}  // namespace glint::gpu::testing
