// SPDX-License-Identifier: MIT
// The inside of the fast CPU detector: its threads, its bounded lists, and that its frame path allocates
// nothing.
#include "gpu/cpu/detector_cpu.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <atomic>
#include <cstdlib>
#include <new>
#include <random>
#include <thread>
#include <vector>

#include "gpu/cpu/keep_first.hpp"
#include "gpu/cpu/workers.hpp"

namespace {
std::atomic<long> allocations{0};
}

// Counts every allocation of this program, on all threads. Not inlined, or else the compiler sees malloc()
// and free() on one side only and takes them for a mismatch.
[[gnu::noinline]] void* operator new(std::size_t bytes) {
  ++allocations;
  void* memory = std::malloc(bytes == 0 ? 1 : bytes);
  if (memory == nullptr) throw std::bad_alloc();
  return memory;
}
[[gnu::noinline]] void operator delete(void* memory) noexcept { std::free(memory); }
[[gnu::noinline]] void operator delete(void* memory, std::size_t) noexcept { std::free(memory); }

namespace glint::gpu {
namespace {

TEST(CpuDetector, AllocatesNothingAfterTheFirstFrame) {
  std::mt19937 random(1);
  const std::vector<CameraFormat> formats(3,
                                          CameraFormat{333, 222, {300, 300, 160, 110, {-0.3, 0.1, 0, 0, 0}}});
  // The first frame is nearly empty; what comes after is as bad as it can be.
  std::vector<std::vector<std::uint8_t>> frames;
  for (const unsigned percent : {1u, 30u, 50u, 99u, 5u}) {
    frames.emplace_back(333 * 222);
    for (auto& p : frames.back()) p = random() % 100 < percent ? 200 : 0;
  }
  DetectorOptions options;
  options.max_blobs_per_camera = 500;
  const auto detector = make_cpu_detector(formats, options);
  const std::vector<std::uint8_t> limit(333 * 222, 40);
  for (std::uint32_t i = 0; i < 3; ++i) detector->set_limit(i, limit);
  BlobBatch batch;
  std::vector<ImageView> views(3);
  long before = 0;
  bool overflow = false;
  for (std::size_t n = 0; n < 40; ++n) {
    for (auto& view : views) view = {frames[n % frames.size()].data(), 333, 222, 333, PixelFormat::Grey8};
    ASSERT_EQ(detector->submit(views), RunStatus::Ok);
    ASSERT_EQ(detector->collect(batch), RunStatus::Ok);
    overflow |= batch.cameras[0].overflow;
    if (n == 0) before = allocations;
  }
  EXPECT_EQ(allocations - before, 0);
  EXPECT_TRUE(overflow);
}

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
    const auto kept = all.sorted();
    ASSERT_EQ(kept.size(), std::min<std::size_t>(capacity, 300));
    for (std::uint32_t i = 0; i < kept.size(); ++i) ASSERT_EQ(kept[i].y_min * 10 + kept[i].x_min, i);
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
