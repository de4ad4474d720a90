// SPDX-License-Identifier: MIT
// Whatever is called in whatever order, with whatever stamps: the ledger balances, sets come in order, frames
// come back.
#include <gtest/gtest.h>

#include <array>
#include <random>

#include "host/assemble/assembler.hpp"
#include "tests/unit/assemble/simulated_rig.hpp"

namespace glint::testing {
namespace {

void run_randomly(std::uint64_t seed, bool with_board) {
  std::mt19937_64 random(seed);
  const auto chance = [&random](double p) { return std::uniform_real_distribution<double>()(random) < p; };
  const auto uniform = [&random](double low, double high) {
    return std::uniform_real_distribution<double>(low, high)(random);
  };
  const std::size_t cameras = 1 + random() % 5;
  AssembleOptions options;
  options.rate_hz = uniform(20.0, 300.0);
  options.most_sets_waiting = 2 + random() % 12;
  if (chance(0.3)) options.deadline_s = uniform(0.0, 1.0) / options.rate_hz;
  const double period = 1.0 / options.rate_hz;

  FramePool pool(std::vector<FrameSize>(cameras, FrameSize{16, 8}), 20);
  FrameSet set;
  Assembler assembler(cameras, options);
  std::array<std::uint32_t, 5> sequence{};
  double now = uniform(0.0, 1e6);
  std::uint64_t board = random() % 1000;
  std::optional<std::uint64_t> last;
  std::uint64_t delivered = 0;
  for (int step = 0; step < 5'000; ++step) {
    now += chance(0.001) ? uniform(0.0, 2000.0) : period * uniform(0.9, 1.1);
    if (with_board) {
      if (chance(0.002)) {
        board = chance(0.5) ? random() : random() % 100;
        last.reset();
      }
      assembler.add_pulse(TriggerNo{board++}, at(now + uniform(-1e-4, 1e-4)), chance(0.9));
      if (chance(0.001)) assembler.add_pulse(TriggerNo{board}, at(now - 1.0), true);
      last.reset();  // a reset board may count lower
    }
    for (std::size_t k = 0; k < cameras; ++k) {
      const CameraId camera{static_cast<std::uint8_t>(k)};
      if (chance(0.003)) assembler.set_present(camera, chance(0.5));
      if (chance(0.001)) assembler.shift(camera, static_cast<int>(random() % 7) - 3);
      for (int copies = chance(0.1) ? 0 : chance(0.05) ? 2 : 1; copies > 0; --copies) {
        std::optional<Frame> frame = pool.take(camera);
        ASSERT_TRUE(frame) << "frames were not given back";
        sequence[k] += chance(0.01) ? static_cast<std::uint32_t>(random()) : chance(0.05) ? 2 : 1;
        frame->sequence = sequence[k];
        frame->damaged = chance(0.02);
        frame->stamp = static_cast<StampPoint>(random() % 4);
        frame->stamped = chance(0.01)
                             ? Timestamp(std::chrono::nanoseconds(static_cast<std::int64_t>(random())))
                         : chance(0.05) ? at(now + uniform(-5.0, 5.0) * period)
                                        : at(now + uniform(-0.1, 0.1) * period);
        assembler.add(std::move(*frame), at(now + uniform(0.0, 0.5) * period));
        ++delivered;
        ASSERT_TRUE(assembler.ledger().balanced());
      }
    }
    while (chance(0.9) && assembler.next(set, at(now + uniform(0.0, 1.0) * period))) {
      ASSERT_TRUE(assembler.ledger().balanced());
      if (last) {
        ASSERT_GT(number(set.trigger), *last);
      }
      if (!with_board) last = number(set.trigger);
    }
    ASSERT_TRUE(assembler.ledger().balanced());
    (void)assembler.due();
    (void)assembler.aligned();
    ASSERT_TRUE(std::isfinite(assembler.exposed_error_s()));
  }
  while (assembler.next(set, at(now + 10.0))) {
  }
  std::uint64_t counted = 0;
  for (const CameraLedger& camera : assembler.ledger().cameras) {
    counted += camera.total() - camera[FrameFate::LostByHost] - camera[FrameFate::LostByCamera];
    counted += camera.duplicates + camera.unplaced + camera.warm_up;
  }
  EXPECT_EQ(counted, delivered);
  EXPECT_TRUE(assembler.ledger().balanced());
}

class RandomCalls : public ::testing::TestWithParam<std::uint64_t> {};

TEST_P(RandomCalls, WithoutBoard) { run_randomly(GetParam(), false); }
TEST_P(RandomCalls, WithBoard) { run_randomly(GetParam(), true); }

INSTANTIATE_TEST_SUITE_P(Seeds, RandomCalls, ::testing::Range(std::uint64_t{0}, std::uint64_t{40}));

}  // namespace
}  // namespace glint::testing
