// SPDX-License-Identifier: MIT
// A warm tick of the CPU detector allocates nothing and grows no heap: on the benchmark's pictures, with
// cameras missing, and where far more blobs come than are kept.
#include <gtest/gtest.h>

#include <random>
#include <vector>

#include "gpu/cpu/detector_cpu.hpp"
#include "host/bench/scene.hpp"
#include "tests/support/allocations.hpp"

namespace glint::gpu {
namespace {

/// Shows the sets in turn, `rounds` times; returns how many blobs were found.
std::size_t show(Detector& detector, const std::vector<std::vector<ImageView>>& sets, int rounds,
                 BlobBatch& batch) {
  std::size_t found = 0;
  for (int round = 0; round < rounds; ++round) {
    for (const std::vector<ImageView>& images : sets) {
      EXPECT_EQ(detector.submit(images), RunStatus::Ok);
      EXPECT_EQ(detector.collect(batch), RunStatus::Ok);
      for (const CameraBlobs& camera : batch.cameras) found += camera.found;
    }
  }
  return found;
}

/// Only the first set is shown before allocations are counted.
std::size_t expect_no_allocation(Detector& detector, const std::vector<std::vector<ImageView>>& sets) {
  BlobBatch batch;
  show(detector, {sets.front()}, 1, batch);
  const std::size_t calls = testing::allocations(), bytes = testing::heap_bytes();
  EXPECT_GT(calls, 0u) << "the counter does not count";
  const std::size_t found = show(detector, sets, 5, batch);
  EXPECT_EQ(testing::allocations(), calls);
  EXPECT_EQ(testing::heap_bytes(), bytes);
  return found;
}

struct Case {
  unsigned blobs, threads;
};

class CpuNoAllocation : public ::testing::TestWithParam<Case> {};

TEST_P(CpuNoAllocation, OnTheBenchmarkScene) {
  bench::SceneOptions scene_options;
  scene_options.blobs_per_camera = GetParam().blobs;
  scene_options.drawn_cameras = 1;
  scene_options.ticks = 2;
  const bench::Scene scene(scene_options);
  std::vector<std::vector<ImageView>> sets(1,
                                           std::vector<ImageView>(scene_options.cameras));  // no frame at all
  for (unsigned tick = 0; tick < scene_options.ticks; ++tick) {
    sets.push_back(scene.images(tick));
    sets.push_back(scene.images(tick));
    sets.back()[tick + 1] = {};
  }
  DetectorOptions options;
  options.threads = GetParam().threads;
  for (const RowKernels& kernels : row_kernels()) {
    const auto detector = make_cpu_detector(scene.formats(), options, kernels);
    for (unsigned i = 0; i < scene_options.cameras; ++i) detector->set_limit(i, scene.limit(i));
    EXPECT_EQ(expect_no_allocation(*detector, sets) > 0, GetParam().blobs > 0) << kernels.name;
  }
}

INSTANTIATE_TEST_SUITE_P(Scenes, CpuNoAllocation,
                         ::testing::Values(Case{0, 1}, Case{0, 2}, Case{20, 1}, Case{20, 2}, Case{200, 1},
                                           Case{200, 2}, Case{2000, 1}, Case{2000, 2}),
                         [](const auto& test) {
                           return std::to_string(test.param.blobs) + "_blobs_" +
                                  std::to_string(test.param.threads) + "_threads";
                         });

TEST(CpuNoAllocation, WhenThereIsFarTooMuch) {
  std::mt19937 random(1);
  const std::vector<CameraFormat> formats(3, {333, 222, {300, 300, 160, 110, {-0.3, 0.1, 0, 0, 0}}});
  // The first frame is nearly empty; what comes after is as bad as it can be.
  std::vector<std::vector<std::uint8_t>> frames;
  std::vector<std::vector<ImageView>> sets;
  for (const unsigned percent : {1u, 30u, 50u, 99u, 5u}) {
    std::vector<std::uint8_t>& frame = frames.emplace_back(333 * 222);
    for (auto& p : frame) p = random() % 100 < percent ? 200 : 0;
    sets.emplace_back(3, ImageView{frame.data(), 333, 222, 333, PixelFormat::Grey8});
  }
  for (const unsigned threads : {1u, 2u, 5u}) {
    DetectorOptions options;
    options.max_blobs_per_camera = 500;
    options.threads = threads;
    const auto detector = make_cpu_detector(formats, options);
    const std::vector<std::uint8_t> limit(333 * 222, 40);
    for (std::uint32_t i = 0; i < 3; ++i) detector->set_limit(i, limit);
    EXPECT_GT(expect_no_allocation(*detector, sets), 500u);
  }
}

}  // namespace
}  // namespace glint::gpu
