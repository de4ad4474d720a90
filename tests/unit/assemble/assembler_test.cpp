// SPDX-License-Identifier: MIT
// What the assembler promises, one promise at a time.
#include "host/assemble/assembler.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <numeric>
#include <set>
#include <utility>

#include "host/base/error.hpp"
#include "tests/unit/assemble/simulated_rig.hpp"

namespace glint::testing {
namespace {

constexpr double kPeriod = 1.0 / 90.0;
constexpr std::array<std::size_t, 3> kWithoutTwo{0, 1, 3};

/// A rig on time with an assembler that has seen 40 pulses, and a hand to feed more.
class AssemblerTest : public ::testing::Test {
 protected:
  AssemblerTest() : AssemblerTest(AssembleOptions{}) {}
  explicit AssemblerTest(const AssembleOptions& options)
      : pool(std::vector<FrameSize>(4, FrameSize{16, 8}), 64), assembler(4, options) {}

  double pulse_s(std::int64_t pulse) const { return 100.0 + static_cast<double>(pulse) * kPeriod; }
  /// Time of the stamp; the frame arrives a millisecond later, or as told.
  void feed(std::size_t camera, std::int64_t pulse, double late_s = 0.0) {
    feed_stamped(camera, pulse, pulse_s(pulse), pulse_s(pulse) + 1e-3 + late_s);
  }
  void feed_stamped(std::size_t camera, std::int64_t pulse, double stamped_s, double arrived_s) {
    std::optional<Frame> frame = pool.take(CameraId{static_cast<std::uint8_t>(camera)});
    ASSERT_TRUE(frame);
    frame->pixels()[0] = static_cast<std::uint8_t>(pulse & 0xff);
    frame->sequence = sequence_is_pulse ? static_cast<std::uint32_t>(pulse) : sequence[camera]++;
    frame->stamped = at(stamped_s);
    frame->stamp = stamp;
    assembler.add(std::move(*frame), at(arrived_s));
  }
  void feed_all(std::int64_t pulse) {
    for (std::size_t camera = 0; camera < 4; ++camera) feed(camera, pulse);
  }
  bool take(double now_s) {
    if (!assembler.next(set, at(now_s))) return false;
    frames = 0;
    contents.clear();
    for (std::optional<Frame>& frame : set.frames) {
      if (!frame) continue;
      ++frames;
      contents.insert(frame->pixels()[0]);
    }
    return true;
  }
  void take_all(double now_s) {
    while (take(now_s)) EXPECT_EQ(contents.size(), 1u) << "frames of different pulses";
  }
  void warm_up(std::int64_t from = 0, std::int64_t pulses = 40) {
    for (std::int64_t pulse = from; pulse < from + pulses; ++pulse) {
      feed_all(pulse);
      while (take(pulse_s(pulse) + 2e-3)) {
        if (zero < 0) zero = pulse - static_cast<std::int64_t>(number(set.trigger));
      }
    }
    EXPECT_TRUE(assembler.aligned());
  }
  /// True pulse of the set.
  std::int64_t pulse_of_set() const { return static_cast<std::int64_t>(number(set.trigger)) + zero; }
  const CameraLedger& camera(std::size_t k) const { return assembler.ledger().cameras[k]; }

  FramePool pool;
  FrameSet set;  // after the pool: it ends first
  Assembler assembler;
  std::array<std::uint32_t, 4> sequence{};
  bool sequence_is_pulse = true;
  StampPoint stamp = StampPoint::StartOfExposure;
  std::int64_t zero = -1;
  std::size_t frames = 0;           // in the last set
  std::set<std::uint8_t> contents;  // true pulses of its frames, the last byte
};

TEST_F(AssemblerTest, HoldsBackUntilPulsesCanBeToldApart) {
  std::int64_t pulse = 0;
  for (; !assembler.aligned(); ++pulse) {
    ASSERT_LT(pulse, 30);
    feed_all(pulse);
    if (!assembler.aligned()) {
      EXPECT_FALSE(take(pulse_s(pulse) + 0.1));
    }
  }
  EXPECT_GE(pulse, 20);
  EXPECT_EQ(assembler.ledger().pulses, 0u);
  EXPECT_EQ(camera(0).warm_up, static_cast<std::uint64_t>(pulse));
  feed_all(pulse);
  ASSERT_TRUE(take(pulse_s(pulse) + 1e-3));
  EXPECT_EQ(number(set.trigger), 0u);
  EXPECT_EQ(frames, 4u);
  EXPECT_LT(std::abs(seconds_between(at(pulse_s(pulse)), set.exposed)), 20e-6);
  EXPECT_EQ(set.delivered, at(pulse_s(pulse) + 1e-3));
}

TEST_F(AssemblerTest, ASilentCameraDoesNotKeepTheOthersFromStarting) {
  std::int64_t pulse = 0;
  for (; pulse < 60; ++pulse) {
    for (std::size_t k = 0; k < 3; ++k) feed(k, pulse);
    take_all(pulse_s(pulse) + 2e-3);
  }
  EXPECT_TRUE(assembler.aligned());
  EXPECT_EQ(frames, 3u);
  const std::uint64_t before = assembler.ledger().pulses;
  // It comes to life, and joins once its clock is known.
  for (; pulse < 100; ++pulse) {
    feed_all(pulse);
    take_all(pulse_s(pulse) + 2e-3);
  }
  EXPECT_EQ(frames, 4u);
  EXPECT_EQ(assembler.ledger().pulses, before + 40);
  EXPECT_EQ(camera(3)[FrameFate::Used] + camera(3).unplaced, 40u);
  EXPECT_TRUE(assembler.ledger().balanced());
}

TEST_F(AssemblerTest, WaitsForTheDeadlineAndNotLonger) {
  warm_up();
  for (std::size_t k = 0; k < 3; ++k) feed(k, 40);
  const double deadline_s = pulse_s(40) + 1e-3 + 0.5 * kPeriod;
  EXPECT_FALSE(take(deadline_s - 50e-6));
  ASSERT_TRUE(assembler.due());
  EXPECT_NEAR(seconds_between(at(deadline_s), *assembler.due()), 0.0, 50e-6);
  ASSERT_TRUE(take(seconds_between(Timestamp{}, *assembler.due())));
  EXPECT_EQ(frames, 3u);
  EXPECT_EQ(pulse_of_set(), 40);
  EXPECT_FALSE(assembler.due());
  feed(3, 40, 0.7 * kPeriod);
  EXPECT_EQ(camera(3)[FrameFate::Late], 1u);
  EXPECT_FALSE(take(pulse_s(41)));
}

TEST_F(AssemblerTest, DoesNotWaitForACameraThatIsGone) {
  warm_up();
  assembler.set_present(CameraId{2}, false);
  for (const std::size_t k : kWithoutTwo) feed(k, 40);
  ASSERT_TRUE(take(pulse_s(40) + 1e-3));
  EXPECT_EQ(frames, 3u);
  // Back, a thousand pulses later, with a stream that counts from 0.
  for (std::int64_t pulse = 41; pulse < 1041; ++pulse) {
    for (const std::size_t k : kWithoutTwo) feed(k, pulse);
    ASSERT_TRUE(take(pulse_s(pulse) + 1e-3));
  }
  sequence_is_pulse = false;
  feed(2, 1041);
  sequence_is_pulse = true;
  for (const std::size_t k : kWithoutTwo) feed(k, 1041);
  ASSERT_TRUE(take(pulse_s(1041) + 1e-3));
  EXPECT_EQ(frames, 4u);
  EXPECT_EQ(pulse_of_set(), 1041);
  EXPECT_EQ(camera(2)[FrameFate::LostByCamera], 1001u);
}

TEST_F(AssemblerTest, AnAbsentCameraThatDeliversIsPresent) {
  warm_up();
  assembler.set_present(CameraId{2}, false);
  feed(2, 40);
  feed(0, 41);
  feed(1, 41);
  feed(3, 41);
  EXPECT_TRUE(take(pulse_s(41) + 1e-3));   // 40, past its deadline
  EXPECT_FALSE(take(pulse_s(41) + 1e-3));  // 41 waits for camera 2
}

TEST_F(AssemblerTest, TakesStampsInTheFarFutureOrPastForNoPulse) {
  warm_up();
  feed_stamped(0, 40, pulse_s(40) + 20 * kPeriod, pulse_s(40) + 1e-3);
  feed_stamped(0, 41, pulse_s(41) - 5.0, pulse_s(41) + 1e-3);
  feed_stamped(0, 42, -9.2e9, pulse_s(42) + 1e-3);
  feed_stamped(0, 43, 9.2e9, pulse_s(43) + 1e-3);
  feed_stamped(0, 44, pulse_s(44) + 0.5 * kPeriod, pulse_s(45));
  EXPECT_EQ(camera(0).unplaced, 5u);
  EXPECT_FALSE(assembler.due());
  EXPECT_TRUE(assembler.aligned());
}

TEST_F(AssemblerTest, FollowsAClockThatJumped) {
  warm_up();
  // The stamps of camera 1 wrap: from now on they are on a clock of their own, centuries away.
  constexpr double kJump = -9.2e9;
  for (std::int64_t pulse = 40; pulse < 120; ++pulse) {
    for (const std::size_t k : {0U, 2U, 3U}) feed(k, pulse);
    feed_stamped(1, pulse, pulse_s(pulse) + kJump, pulse_s(pulse) + 1e-3);
    take_all(pulse_s(pulse) + 2e-3);
    if (pulse == 60) {
      EXPECT_FALSE(assembler.aligned(CameraId{1}));
      EXPECT_TRUE(assembler.aligned(CameraId{0}));
      EXPECT_FALSE(assembler.aligned());
    }
  }
  EXPECT_TRUE(assembler.aligned());
  EXPECT_EQ(frames, 4u);
  EXPECT_EQ(pulse_of_set(), 119);
  EXPECT_GT(camera(1).unplaced, 12u);
  EXPECT_LT(camera(1).unplaced, 45u);
  EXPECT_EQ(camera(1)[FrameFate::LostByHost], 0u);  // all were delivered
  EXPECT_TRUE(assembler.ledger().balanced());
}

TEST_F(AssemblerTest, FitsAnewWhenTheTriggerWasRestarted) {
  warm_up();
  // All stamps move by 0.4 of a period after a pause of two seconds.
  for (std::int64_t pulse = 220; pulse < 300; ++pulse) {
    for (std::size_t k = 0; k < 4; ++k) {
      const double stamped = pulse_s(pulse) + 0.42 * kPeriod;
      feed_stamped(k, pulse, stamped, stamped + 1e-3);
    }
    take_all(pulse_s(pulse) + 0.42 * kPeriod + 2e-3);
  }
  EXPECT_TRUE(assembler.aligned());
  EXPECT_EQ(frames, 4u);
  EXPECT_EQ(pulse_of_set(), 299);
  EXPECT_TRUE(assembler.ledger().balanced());
}

TEST_F(AssemblerTest, AQuietRigIsNotCountedUntilItGoesOn) {
  warm_up();
  const std::uint64_t pulses = assembler.ledger().pulses;
  EXPECT_FALSE(take(pulse_s(400)));
  EXPECT_EQ(assembler.ledger().pulses, pulses);
  feed_all(400);
  ASSERT_TRUE(take(pulse_s(400) + 1e-3));
  EXPECT_EQ(pulse_of_set(), 400);
  EXPECT_EQ(assembler.ledger().pulses, pulses + 361);
}

TEST_F(AssemblerTest, DropsWhatIsOldOnceBehind) {
  warm_up();
  for (std::int64_t pulse = 40; pulse < 46; ++pulse) feed_all(pulse);
  ASSERT_TRUE(take(pulse_s(45) + 1.1e-3));
  EXPECT_EQ(pulse_of_set(), 45);
  EXPECT_EQ(camera(0)[FrameFate::Skipped], 5u);
  // A hiccup of less than two periods loses nothing.
  for (std::int64_t pulse = 46; pulse < 48; ++pulse) feed_all(pulse);
  ASSERT_TRUE(take(pulse_s(47) + 0.8 * kPeriod));
  EXPECT_EQ(pulse_of_set(), 46);
  ASSERT_TRUE(take(pulse_s(47) + 0.9 * kPeriod));
  EXPECT_EQ(pulse_of_set(), 47);
  EXPECT_EQ(camera(0)[FrameFate::Skipped], 5u);
}

TEST_F(AssemblerTest, HoldsNoMoreSetsThanAllowed) {
  warm_up();
  for (std::int64_t pulse = 40; pulse < 240; ++pulse) feed_all(pulse);  // or the pool would run dry
  EXPECT_EQ(camera(0)[FrameFate::Skipped], 192u);
  EXPECT_TRUE(assembler.ledger().balanced());
}

TEST_F(AssemblerTest, ShiftMovesACameraByWholePulses) {
  warm_up();
  // Camera 2 was taken for a pulse too early: its frame of 41 is at the time of 40.
  feed(2, 40);
  assembler.shift(CameraId{2}, 1);
  for (std::int64_t pulse = 41; pulse < 60; ++pulse) {
    for (const std::size_t k : kWithoutTwo) feed(k, pulse);
    feed_stamped(2, pulse, pulse_s(pulse - 1), pulse_s(pulse - 1) + 1e-3);
    take_all(pulse_s(pulse) + 2e-3);
    EXPECT_EQ(frames, 4u);
  }
  EXPECT_EQ(camera(2)[FrameFate::Skipped], 1u);  // the one that was held
  EXPECT_TRUE(assembler.ledger().balanced());
}

/// What coded pulses rest upon: nobody can have slipped within a run.
TEST_F(AssemblerTest, ARunOfFramesEndsWithEveryIrregularStep) {
  warm_up();
  sequence_is_pulse = false;
  sequence.fill(40);
  std::int64_t pulse = 40;
  const auto run_of = [&](std::size_t k) {
    for (std::size_t c = 0; c < 4; ++c) feed(c, pulse);
    EXPECT_TRUE(take(pulse_s(pulse) + 2e-3));
    ++pulse;
    return set.frames[k] ? set.frames[k]->run : ~0U;
  };
  std::uint32_t run = run_of(2);
  for (int n = 0; n < 20; ++n) EXPECT_EQ(run_of(2), run);
  const auto changed = [&] {
    const std::uint32_t before = std::exchange(run, run_of(2));
    for (int n = 0; n < 3; ++n) EXPECT_EQ(run_of(2), run);
    return run != before;
  };
  EXPECT_FALSE(changed());
  // Lost by the host: the driver counted it.
  for (const std::size_t k : kWithoutTwo) feed(k, pulse);
  ++sequence[2];
  while (take(pulse_s(pulse) + 0.9 * kPeriod)) {
  }
  ++pulse;
  EXPECT_FALSE(changed());
  // Never sent.
  for (const std::size_t k : kWithoutTwo) feed(k, pulse);
  while (take(pulse_s(pulse) + 0.9 * kPeriod)) {
  }
  ++pulse;
  EXPECT_TRUE(changed());
  feed(2, pulse - 1, 1e-3);  // sent twice
  EXPECT_TRUE(changed());
  sequence[2] = 0;  // a new stream
  EXPECT_TRUE(changed());
  assembler.set_present(CameraId{2}, false);
  EXPECT_TRUE(changed());
  EXPECT_EQ(set.frames[2]->shifted, 0);
  EXPECT_EQ(set.frames[0]->run, set.frames[1]->run) << "nothing happened to the others";
  assembler.shift(CameraId{2}, 1);
  assembler.shift(CameraId{2}, -2);
  std::uint64_t shifted = 0;
  for (const std::int64_t end = pulse + 5; pulse < end; ++pulse) {
    feed_all(pulse);
    while (take(pulse_s(pulse) + 2e-3)) {
      EXPECT_EQ(set.frames[0]->shifted, 0);
      if (!set.frames[2]) continue;
      ++shifted;
      EXPECT_EQ(set.frames[2]->shifted, -1);
      EXPECT_NE(set.frames[2]->run, run);
    }
  }
  EXPECT_GE(shifted, 3u);
}

TEST_F(AssemblerTest, TheBoardNumbersThePulses) {
  // Irregular pulses, numbered from 5000; frames are read out 8 ms after the pulse.
  std::vector<double> fired;
  double time = 100.0;
  for (int k = 0; k < 300; ++k) fired.push_back(time += kPeriod * (k % 3 == 0 ? 1.04 : 0.98));
  stamp = StampPoint::EndOfFrame;
  std::uint64_t sets = 0;
  for (std::size_t k = 0; k < fired.size(); ++k) {
    const bool dark = k % 20 == 7;
    if (k != 150) assembler.add_pulse(TriggerNo{5000 + k}, at(fired[k]), !dark);
    for (std::size_t c = 0; c < 4; ++c) {
      feed_stamped(c, static_cast<std::int64_t>(k), fired[k] + 8e-3, fired[k] + 8.5e-3);
    }
    while (take(fired[k] + 8.6e-3)) {
      ++sets;
      EXPECT_EQ(number(set.trigger), 5000 + k);
      EXPECT_EQ(set.dark, dark);
      EXPECT_EQ(frames, 4u);
      EXPECT_EQ(contents, std::set<std::uint8_t>{static_cast<std::uint8_t>(k)});
      if (k != 150) {
        EXPECT_LT(std::abs(seconds_between(at(fired[k]), set.exposed)), 2e-9);
      }
    }
  }
  EXPECT_TRUE(assembler.aligned());
  const Ledger& ledger = assembler.ledger();
  EXPECT_EQ(ledger.pulses, 300 - camera(0).warm_up);
  EXPECT_EQ(camera(0)[FrameFate::Dark], 14u);  // of 15, one in the warm-up
  EXPECT_EQ(camera(0)[FrameFate::Used] + camera(0)[FrameFate::Dark], sets);
  EXPECT_EQ(sets, ledger.pulses);
  EXPECT_TRUE(ledger.balanced());
}

TEST_F(AssemblerTest, APulseThatNoCameraSawIsCountedIfTheBoardSaysSo) {
  for (std::int64_t pulse = 0; pulse < 40; ++pulse) {
    assembler.add_pulse(TriggerNo{static_cast<std::uint64_t>(pulse)}, at(pulse_s(pulse)), true);
    feed_all(pulse);
    take_all(pulse_s(pulse) + 2e-3);
  }
  const std::uint64_t pulses = assembler.ledger().pulses;
  for (std::int64_t pulse = 40; pulse < 45; ++pulse) {
    assembler.add_pulse(TriggerNo{static_cast<std::uint64_t>(pulse)}, at(pulse_s(pulse)), true);
  }
  EXPECT_FALSE(take(pulse_s(46)));
  EXPECT_EQ(assembler.ledger().pulses, pulses + 5);
  EXPECT_EQ(camera(0)[FrameFate::LostByCamera], 5u);
}

TEST_F(AssemblerTest, ABoardThatWasResetStartsANewCount) {
  const auto run = [this](std::int64_t from, std::int64_t to, std::int64_t shown) {
    for (std::int64_t pulse = from; pulse < to; ++pulse) {
      assembler.add_pulse(TriggerNo{static_cast<std::uint64_t>(pulse + shown)}, at(pulse_s(pulse)), true);
      feed_all(pulse);
      while (take(pulse_s(pulse) + 2e-3)) {
        EXPECT_EQ(static_cast<std::int64_t>(number(set.trigger)), pulse + shown);
      }
    }
  };
  run(0, 60, 1000);
  EXPECT_TRUE(assembler.aligned());
  run(60, 61, -60);
  EXPECT_FALSE(assembler.aligned());
  run(61, 140, -60);
  EXPECT_TRUE(assembler.aligned());
  EXPECT_EQ(number(set.trigger), 79u);
  EXPECT_TRUE(assembler.ledger().balanced());
}

TEST(AssembleOptions, AreChecked) {
  std::vector<std::string> problems;
  AssembleOptions options;
  options.check(problems);
  EXPECT_TRUE(problems.empty());
  options.rate_hz = 0.0;
  EXPECT_THROW(Assembler(4, options), UsageError);
  options.rate_hz = 90.0;
  options.deadline_s = 0.1;
  EXPECT_THROW(Assembler(4, options), UsageError);
  options.most_sets_waiting = 16;
  EXPECT_NO_THROW(Assembler(4, options));
  options.deadline_s = -0.1;
  EXPECT_THROW(Assembler(4, options), UsageError);
  EXPECT_THROW(Assembler(0, AssembleOptions{}), UsageError);
  EXPECT_THROW(Assembler(33, AssembleOptions{}), UsageError);
}

/// Sets wait long enough that order of arrival is all that differs.
class ArrivalOrder : public AssemblerTest {
 protected:
  static AssembleOptions patient() {
    AssembleOptions options;
    options.deadline_s = 5.5 * kPeriod;
    return options;
  }
  ArrivalOrder() : AssemblerTest(patient()) { warm_up(); }
  /// Feeds frames of the pulses from `first` on, in the order of `order` (camera + 4 * pulse), all in the
  /// time of the last pulse; expects the complete sets in order of pulses.
  void expect_sets(const std::vector<int>& order, std::int64_t first, std::int64_t pulses) {
    double arrived = pulse_s(first + pulses - 1) + 1e-3;
    std::int64_t next = first;
    for (const int k : order) {
      const std::int64_t pulse = first + k / 4;
      feed_stamped(static_cast<std::size_t>(k % 4), pulse, pulse_s(pulse), arrived);
      arrived += 1e-6;
      while (take(arrived)) {
        ASSERT_EQ(pulse_of_set(), next);
        ASSERT_EQ(frames, 4u);
        ASSERT_EQ(contents, std::set<std::uint8_t>{static_cast<std::uint8_t>(next)});
        ++next;
      }
    }
    ASSERT_EQ(next, first + pulses);
    // As many in time, so that lateness does not become the rule.
    for (; next < first + 2 * pulses; ++next) {
      feed_all(next);
      ASSERT_TRUE(take(pulse_s(next) + 1e-3));
    }
  }
};

TEST_F(ArrivalOrder, EveryInterleavingOfFourCamerasAndThreePulsesGivesTheSameSets) {
  std::int64_t first = 40;
  std::uint64_t orders = 0;
  std::array<int, 4> given{};
  std::vector<int> order;
  const std::function<void()> extend = [&] {
    if (HasFatalFailure()) return;
    if (order.size() == 12) {
      expect_sets(order, first, 3);
      first += 6;
      ++orders;
      return;
    }
    for (int c = 0; c < 4; ++c) {
      int& of_camera = given[static_cast<std::size_t>(c)];
      if (of_camera == 3) continue;
      order.push_back(c + 4 * of_camera++);
      extend();
      order.pop_back();
      --of_camera;
    }
  };
  extend();
  EXPECT_EQ(orders, 369'600u);
  EXPECT_EQ(camera(0)[FrameFate::Used], assembler.ledger().pulses);
  EXPECT_TRUE(assembler.ledger().balanced());
}

TEST_F(ArrivalOrder, ShuffledFramesOfFourCamerasAndSixPulsesGiveTheSameSets) {
  std::mt19937_64 random(5);
  std::vector<int> order(24);
  std::iota(order.begin(), order.end(), 0);
  for (int run = 0; run < 20'000 && !HasFatalFailure(); ++run) {
    std::shuffle(order.begin(), order.end(), random);
    expect_sets(order, 40 + 12 * run, 6);
  }
  EXPECT_EQ(camera(0)[FrameFate::Used], assembler.ledger().pulses);
}

TEST(SlowConsumer, GetsNewSetsAndEveryFrameIsAccountedFor) {
  RigOptions rig;
  rig.pulses = 20'000;
  rig.jitter_s = 0.2e-3;
  rig.faults = {.never_sent = 0.01, .lost_by_host = 0.01, .twice = 0.01, .late = 0.01, .corrupt = 0.01};
  const SimulatedRig simulated(rig);
  RigRun run(simulated, AssembleOptions{}, 0.030);  // a consumer that needs 30 ms for each
  run.run();
  EXPECT_EQ(run.mispaired, 0u);
  EXPECT_EQ(run.unbalanced, 0u);
  EXPECT_EQ(run.not_in_order, 0u);
  EXPECT_LT(run.oldest_s, 2.0 * simulated.period_s + 0.5e-3);
  const Ledger& ledger = run.assembler().ledger();
  EXPECT_NEAR(static_cast<double>(run.sets), 20'000.0 * simulated.period_s / 0.030, 120.0);
  for (std::size_t camera = 0; camera < 4; ++camera) {
    const CameraLedger expected = run.expected(camera);
    const CameraLedger& got = ledger.cameras[camera];
    using enum FrameFate;
    EXPECT_EQ(got[LostByHost], expected[LostByHost]);
    EXPECT_EQ(got[LostByCamera], expected[LostByCamera]);
    EXPECT_EQ(got[Corrupt], expected[Corrupt]);
    EXPECT_EQ(got[Used] + got[Skipped] + got[Late], expected[Used] + expected[Late]);
    EXPECT_GT(got[Skipped], got[Used]);
  }
}

}  // namespace
}  // namespace glint::testing
