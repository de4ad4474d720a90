// SPDX-License-Identifier: MIT
#include "usb-sync/clock_model.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <random>
#include <vector>

#include "tests/support/allocations.hpp"
#include "tests/unit/usb-sync/simulated_clocks.hpp"

namespace glint::sync {
namespace {

using namespace std::chrono_literals;

constexpr std::uint32_t kTickHz = SimulatedClocks::kTickHz;
constexpr Seconds kRounding{2e-9};  // ticks and nanoseconds are whole

struct Outcome {
  std::vector<double> errors_s, half_widths_s;  // after the first 5 s
  std::size_t samples = 0, outside = 0;         // of all
  std::uint64_t contradictions = 0;

  double error_us(double share) { return 1e6 * quantile(errors_s, share); }
  double half_width_us(double share) { return 1e6 * quantile(half_widths_s, share); }

 private:
  static double quantile(std::vector<double>& values, double share) {
    const auto at = static_cast<std::ptrdiff_t>(share * static_cast<double>(values.size() - 1));
    std::nth_element(values.begin(), values.begin() + at, values.end());
    return values[static_cast<std::size_t>(at)];
  }
};

/// Triggers at that rate, and 20 time queries a second, for `seconds`, under many seeds.
Outcome simulate(const SimulatedClocks::Delays& delays, double trigger_hz, double seconds,
                 std::uint64_t seeds) {
  Outcome outcome;
  for (std::uint64_t seed = 1; seed <= seeds; ++seed) {
    SimulatedClocks clocks(seed, delays);
    ClockModel model(kTickHz);
    double query_s = 0.001, trigger_s = 0.01;
    while (query_s < seconds) {
      if (query_s < trigger_s) {
        model.add(clocks.query(query_s));
        query_s += 0.05 * (0.75 + 0.5 * clocks.share());
        continue;
      }
      const std::uint64_t tick = clocks.tick(trigger_s);
      model.add_arrival(tick, clocks.arrival(trigger_s));
      const HostInterval estimate = *model.at(tick);
      const Seconds error = std::chrono::abs(Seconds(estimate.time - clocks.host(trigger_s)));
      ++outcome.samples;
      if (error > estimate.half_width + kRounding) ++outcome.outside;
      if (trigger_s > 5.0) {
        outcome.errors_s.push_back(error.count());
        outcome.half_widths_s.push_back(estimate.half_width.count());
      }
      trigger_s += 1.0 / trigger_hz;
    }
    outcome.contradictions += model.contradictions();
  }
  return outcome;
}

void expect_good(Outcome outcome, const char* trace) {
  const double p99_us = outcome.error_us(0.99), half_width_us = outcome.half_width_us(0.99);
  EXPECT_LE(p99_us, 20.0) << trace;
  EXPECT_LE(half_width_us, 60.0) << trace;  // a bound that says nothing would be easy
  EXPECT_LE(static_cast<double>(outcome.outside), 0.001 * static_cast<double>(outcome.samples)) << trace;
  EXPECT_EQ(outcome.contradictions, 0u) << trace;
  std::printf("%s: error p50 %.1f, p99 %.1f us; half-width p50 %.1f, p99 %.1f us; outside %zu of %zu\n",
              trace, outcome.error_us(0.5), p99_us, outcome.half_width_us(0.5), half_width_us,
              outcome.outside, outcome.samples);
}

TEST(ClockModel, IsRightWithin20MicrosecondsAfter5SecondsAndItsBoundHolds) {
  expect_good(simulate({}, 90.0, 30.0, 60), "polling, stalls, slow requests");
}

TEST(ClockModel, LopsidedRoundTripsDoNotBendIt) {
  expect_good(simulate({.request_s = 0.1e-3, .answer_s = 1e-3}, 90.0, 30.0, 60), "slow answers");
  expect_good(simulate({.request_s = 1e-3, .answer_s = 1e-3}, 90.0, 30.0, 60), "both slow");
}

TEST(ClockModel, FewAndManyTriggersAreFine) {
  expect_good(simulate({}, 10.0, 30.0, 60), "10 Hz");
  expect_good(simulate({}, 1000.0, 15.0, 8), "1 kHz");
}

TEST(ClockModel, IsAsGoodAfterAnHour) { expect_good(simulate({}, 90.0, 3600.0, 1), "an hour"); }

TEST(ClockModel, AMachineThatStallsOftenWidensTheBoundAtWorst) {
  const Outcome outcome = simulate({.stall_s = 20e-3, .stall_share = 0.5}, 90.0, 30.0, 30);
  EXPECT_EQ(outcome.outside, 0u);
  EXPECT_EQ(outcome.contradictions, 0u);
}

TEST(ClockModel, TimeQueriesAloneWillDo) {
  SimulatedClocks clocks(3, {});
  ClockModel model(kTickHz);
  for (double t = 0.0; t < 20.0; t += 0.05) model.add(clocks.query(t + 0.01 * clocks.share()));
  const HostInterval estimate = *model.at(clocks.tick(20.0));
  EXPECT_LE(estimate.half_width, 100us);
  EXPECT_LE(std::chrono::abs(Seconds(estimate.time - clocks.host(20.0))), estimate.half_width);
}

TEST(ClockModel, KnowsNothingBeforeItsFirstQuery) {
  ClockModel model(kTickHz);
  model.add_arrival(1000, HostTime(5s));
  EXPECT_FALSE(model.at(1000));
  model.add({HostTime(5s), HostTime(5s + 1ms), 1000, 1});
  ASSERT_TRUE(model.at(1000));
  EXPECT_LE(model.at(1000)->half_width, 1ms);
}

TEST(ClockModel, TheBoundGrowsIntoThePastAndTheFuture) {
  SimulatedClocks clocks(4, {});
  ClockModel model(kTickHz);
  for (double t = 0.0; t < 30.0; t += 0.05) model.add(clocks.query(t));
  const auto width = [&](double t) { return model.at(clocks.tick(t))->half_width; };
  EXPECT_LT(width(30.0), width(60.0));
  EXPECT_LT(width(60.0), width(600.0));
  EXPECT_LT(width(25.0), width(5.0));
  for (const double t : {0.0, 10.0, 30.0, 35.0, 60.0, 200.0}) {
    EXPECT_LE(std::chrono::abs(Seconds(model.at(clocks.tick(t))->time - clocks.host(t))),
              width(t) + kRounding);
  }
}

TEST(ClockModel, LearnsTheRate) {
  SimulatedClocks clocks(6, {});
  ClockModel model(kTickHz);
  for (double t = 0.0; t < 60.0; t += 0.05) model.add(clocks.query(t));
  const double truth = Seconds(clocks.host(60.0) - clocks.host(59.0)).count() - 1.0;
  EXPECT_NEAR(model.rate_error(), truth, 10e-6);
}

TEST(ClockModel, AResetBoardIsANewClock) {
  SimulatedClocks clocks(7, {});
  ClockModel model(kTickHz);
  for (double t = 0.0; t < 10.0; t += 0.05) model.add(clocks.query(t));
  const HostTime now = clocks.host(10.0);
  for (const std::uint64_t tick : {std::uint64_t{5000}, clocks.tick(3600.0)}) {  // its counter is anywhere
    ClockModel reset = model;
    reset.add({now, now + 1ms, tick, 2});
    const HostInterval estimate = *reset.at(tick);
    EXPECT_GE(estimate.time, now);
    EXPECT_LE(estimate.time, now + 1ms);
    EXPECT_EQ(reset.contradictions(), 0u);
  }
}

TEST(ClockModel, AHostClockThatJumpsIsNoticedAndTakenUpAgain) {
  SimulatedClocks clocks(8, {});
  ClockModel model(kTickHz);
  for (double t = 0.0; t < 10.0; t += 0.05) model.add(clocks.query(t));
  for (double t = 10.0; t < 20.0; t += 0.05) {
    TimeAnswer answer = clocks.query(t);
    answer.asked += 30s;
    answer.answered += 30s;
    model.add(answer);
    EXPECT_LE(std::chrono::abs(Seconds(model.at(answer.tick)->time - clocks.host(t) - 30s)),
              model.at(answer.tick)->half_width + kRounding);
  }
  EXPECT_EQ(model.contradictions(), 1u);
}

TEST(ClockModel, NonsenseFromTheWireDoesNotBreakIt) {
  std::mt19937_64 random(9);
  ClockModel model(kTickHz);
  for (int i = 0; i < 20'000; ++i) {
    const std::uint64_t tick = random() >> random() % 64;
    const HostTime when{std::chrono::nanoseconds(random() % 1'000'000'000'000)};
    if (random() % 2 == 0) {
      model.add({when, when + std::chrono::nanoseconds(random() % 10'000'000), tick, i < 10'000 ? 1u : 2u});
    } else {
      model.add_arrival(tick, when);
    }
    if (const auto estimate = model.at(random())) {
      ASSERT_GE(estimate->half_width, 0s);
    }
  }
  // And then it is as good as new.
  SimulatedClocks clocks(10, {});
  for (double t = 0.0; t < 10.0; t += 0.05) {
    TimeAnswer answer = clocks.query(t);
    answer.epoch = 3;
    model.add(answer);
  }
  EXPECT_LE(std::chrono::abs(Seconds(model.at(clocks.tick(10.0))->time - clocks.host(10.0))), 200us);
}

TEST(ClockModel, NothingIsAllocated) {
  SimulatedClocks clocks(11, {});
  ClockModel model(kTickHz);
  const std::size_t before = glint::testing::allocations();
  for (double t = 0.0; t < 60.0; t += 0.01) {
    model.add(clocks.query(t));
    model.add_arrival(clocks.tick(t), clocks.arrival(t));
    (void)model.at(clocks.tick(t));
  }
  EXPECT_EQ(glint::testing::allocations(), before);
}

TEST(Envelope, WhatItDropsWouldChangeNothing) {
  std::mt19937_64 random(12);
  std::uniform_real_distribution<double> share;
  constexpr double kBend = 2e-7;
  for (int round = 0; round < 50; ++round) {
    Envelope upper(Envelope::Side::Below, kBend), lower(Envelope::Side::Above, kBend);
    std::vector<Envelope::Point> above, below;
    for (int i = 0; i < 400; ++i) {
      const double x = 20.0 * share(random), y = 30e-6 * x;
      if (share(random) < 0.5) {
        above.push_back({x, y + 1e-3 * share(random)});
        upper.add(above.back());
      } else {
        below.push_back({x, y - 1e-3 * share(random)});
        lower.add(below.back());
      }
    }
    ASSERT_LT(upper.points().size(), Envelope::kMost);
    for (const double x0 : {-3.0, 0.0, 11.0, 20.0, 30.0}) {
      FeasibleLines all, kept;
      all.start({-1.0, 1.0}, {-1e-3, 1e-3});
      kept = all;
      const auto margin = [&](const Envelope::Point& p) { return 0.5 * kBend * (p.x - x0) * (p.x - x0); };
      for (const auto& p : above) ASSERT_TRUE(all.keep_below(p.x - x0, p.y + margin(p)));
      for (const auto& p : below) ASSERT_TRUE(all.keep_above(p.x - x0, p.y - margin(p)));
      for (const auto& p : upper.points()) ASSERT_TRUE(kept.keep_below(p.x - x0, p.y + margin(p)));
      for (const auto& p : lower.points()) ASSERT_TRUE(kept.keep_above(p.x - x0, p.y - margin(p)));
      EXPECT_NEAR(all.at(0.0).least, kept.at(0.0).least, 1e-12);
      EXPECT_NEAR(all.at(0.0).most, kept.at(0.0).most, 1e-12);
      EXPECT_NEAR(all.rate().most, kept.rate().most, 1e-12);
    }
  }
}

TEST(FeasibleLines, HoldsExactlyTheLinesThatAreAllowed) {
  std::mt19937_64 random(13);
  std::uniform_real_distribution<double> share(-1.0, 1.0);
  FeasibleLines lines;
  lines.start({-1.0, 1.0}, {-1.0, 1.0});
  struct Limit {
    double x, y;
    bool below;
  };
  std::vector<Limit> limits;
  for (int i = 0; i < 30; ++i) {
    const Limit limit{share(random), 0.3 + 0.5 * std::abs(share(random)), i % 2 == 0};
    limits.push_back(limit);
    ASSERT_TRUE(limit.below ? lines.keep_below(limit.x, limit.y) : lines.keep_above(limit.x, -limit.y));
  }
  double least = 1e9, most = -1e9;
  constexpr int kGrid = 1000;
  for (int i = -kGrid; i <= kGrid; ++i) {
    for (int j = -kGrid; j <= kGrid; ++j) {
      const double offset = 1.0 * i / kGrid, rate = 1.0 * j / kGrid;
      const bool allowed = std::all_of(limits.begin(), limits.end(), [&](const Limit& limit) {
        const double y = offset + rate * limit.x;
        return limit.below ? y <= limit.y : y >= -limit.y;
      });
      if (!allowed) continue;
      least = std::min(least, offset + 0.5 * rate);
      most = std::max(most, offset + 0.5 * rate);
    }
  }
  EXPECT_NEAR(lines.at(0.5).least, least, 3e-3);
  EXPECT_NEAR(lines.at(0.5).most, most, 3e-3);
}

TEST(FeasibleLines, AContradictionChangesNothing) {
  FeasibleLines lines;
  lines.start({0.0, 1.0}, {-1.0, 1.0});
  EXPECT_FALSE(lines.keep_below(0.0, -0.5));
  EXPECT_EQ(lines.at(0.0).least, 0.0);
  EXPECT_EQ(lines.at(0.0).most, 1.0);
}

}  // namespace
}  // namespace glint::sync
