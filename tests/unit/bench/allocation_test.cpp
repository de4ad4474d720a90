// SPDX-License-Identifier: MIT
// The measuring loops allocate nothing per tick: ten times the ticks cost not one allocation more.
#include <atomic>
#include <cstdlib>
#include <new>

#include <gtest/gtest.h>

#include "host/bench/measure.hpp"

namespace {
std::atomic<long> allocations{0};
}  // namespace

// The whole program counts; GCC sees malloc behind a new expression and warns of a mismatch that is none.
#pragma GCC diagnostic ignored "-Wmismatched-new-delete"
void* operator new(std::size_t bytes) {
  ++allocations;
  if (void* memory = std::malloc(bytes == 0 ? 1 : bytes)) return memory;
  throw std::bad_alloc();
}
void operator delete(void* memory) noexcept { std::free(memory); }
void operator delete(void* memory, std::size_t) noexcept { std::free(memory); }

namespace glint::bench {
namespace {

TEST(Allocation, NonePerTick) {
  SceneOptions options;
  options.cameras = 2;
  options.width_px = 128;
  options.height_px = 96;
  options.blobs_per_camera = 2;
  const Scene scene(options);
  const Expected expected(scene);
  const auto detector = gpu::make_cpu_detector(scene.formats(), {});
  set_limits(scene, *detector);
  Drive drive(scene, expected, *detector, 2);
  Conditions conditions{50, 50, 2, 100.0, 1000.0};
  warm_up(drive, conditions);
  const auto cost = [&](unsigned ticks, const auto& measured) {
    conditions.ticks = ticks;
    const long before = allocations;
    measured();
    return allocations - before;
  };
  const auto latency = [&] {
    Row row;
    measure_latency(drive, conditions, row);
  };
  const auto throughput = [&] {
    Row row;
    measure_throughput(drive, conditions, row);
  };
  const auto pace = [&] { (void)measure_pace(drive, conditions); };
  EXPECT_GT(cost(50, latency), 0) << "the counter counts";
  EXPECT_EQ(cost(500, latency), cost(50, latency));
  EXPECT_EQ(cost(500, throughput), cost(50, throughput));
  EXPECT_EQ(cost(500, pace), cost(50, pace));
  EXPECT_EQ(drive.outcome(), Outcome::Ok);
}

}  // namespace
}  // namespace glint::bench
