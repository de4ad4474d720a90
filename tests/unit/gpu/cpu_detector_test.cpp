// SPDX-License-Identifier: MIT
// The inside of the fast CPU detector: its threads and its bounded lists.
#include "gpu/cpu/detector_cpu.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <atomic>
#include <random>
#include <thread>
#include <vector>

#include "gpu/cpu/keep_first.hpp"
#include "gpu/cpu/workers.hpp"

namespace glint::gpu {
namespace {

TEST(CpuDetector, NamesItself) {
  const CameraFormat format{8, 8, {}};
  DetectorOptions options;
  options.threads = 1;
  const std::string kernels = row_kernels().front().name;
  EXPECT_EQ(make_cpu_detector({&format, 1}, options)->device_name(), "cpu (1 thread, " + kernels + ")");
  options.threads = 3;
  EXPECT_EQ(make_cpu_detector({&format, 1}, options)->device_name(), "cpu (3 threads, " + kernels + ")");
}

TEST(KeepFirst, KeepsTheFirstWhateverTheOrder) {
  std::vector<BlobMoments> blobs(300);
  for (std::uint32_t i = 0; i < blobs.size(); ++i) {
    blobs[i].y_min = i / 10;
    blobs[i].x_min = i % 10;
  }
  std::mt19937 random(5);
  for (const std::size_t capacity : {1u, 7u, 299u, 300u, 400u}) {
    std::shuffle(blobs.begin(), blobs.end(), random);
    KeepFirst all(capacity), half(capacity);
    for (std::size_t i = 0; i < blobs.size(); ++i) (i % 2 == 0 ? all : half).offer(blobs[i]);
    all.offer_all(half);
    EXPECT_EQ(all.offered(), 300u);
    std::uint32_t kept = 0;
    all.for_each_in_order([&](const BlobMoments& blob) { EXPECT_EQ(blob.y_min * 10 + blob.x_min, kept++); });
    EXPECT_EQ(kept, std::min<std::size_t>(capacity, 300));
    all.clear();
    EXPECT_EQ(all.offered(), 0u);
  }
}

struct Tally {
  static constexpr unsigned kSlots = 3, kItems = 13;
  std::atomic<int> done[kSlots][kItems] = {};
  bool sleepy = false;
  static void work(void* context, unsigned slot, unsigned item) noexcept {
    auto& self = *static_cast<Tally*>(context);
    if (self.sleepy && item % 4 == 0) std::this_thread::sleep_for(std::chrono::microseconds(300));
    ++self.done[slot][item];
  }
};

TEST(Workers, DoEveryItemOfEveryJobOnce) {
  for (const bool sleepy : {false, true}) {
    for (const unsigned helpers : {0u, 1u, 4u}) {
      Tally tally;
      tally.sleepy = sleepy;
      Workers workers(helpers, Tally::kSlots, Tally::kItems, &Tally::work, &tally);
      const int jobs = sleepy ? 60 : 3000;
      workers.start();
      for (int n = 0; n < jobs; ++n) {
        workers.start();  // two jobs under way
        workers.finish(static_cast<unsigned>(n) % Tally::kSlots);
        for (const auto& count : tally.done[static_cast<unsigned>(n) % Tally::kSlots]) {
          ASSERT_EQ(count, n / static_cast<int>(Tally::kSlots) + 1) << n;
        }
      }
      workers.finish(static_cast<unsigned>(jobs) % Tally::kSlots);
    }
  }
}

TEST(Workers, EndWhileTheyWork) {
  for (int i = 0; i < 50; ++i) {
    Tally tally;
    tally.sleepy = i % 2 == 0;
    Workers workers(3, Tally::kSlots, Tally::kItems, &Tally::work, &tally);
    workers.start();
    workers.start();
  }
}

}  // namespace
}  // namespace glint::gpu
