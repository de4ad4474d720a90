// SPDX-License-Identifier: MIT
// A consumer that is too slow for a live source gets new frames, not old ones, and knows what it missed.
#include <gtest/gtest.h>

#include <algorithm>
#include <chrono>
#include <memory>
#include <thread>
#include <vector>

#include "host/assemble/ledger.hpp"
#include "host/pipeline/frame_input.hpp"

namespace glint {
namespace {

using std::chrono::milliseconds;
using std::chrono::steady_clock;

constexpr double kRate_hz = 50.0;
constexpr milliseconds kPeriod{20};

/// One camera, exactly on time, that books every frame it hands over as used.
class SteadySource final : public FrameSource {
 public:
  SteadySource(std::uint64_t sets, double rate_hz) : sets_(sets), rate_hz_(rate_hz) {
    ledger_.cameras.resize(1);
  }
  std::span<const SourceCamera> cameras() const noexcept override { return cameras_; }
  double rate_hz() const noexcept override { return rate_hz_; }
  bool live() const noexcept override { return true; }
  ReadStatus read(FramePool& pool, FrameSet& set) noexcept override {
    if (given_ == sets_) return ReadStatus::End;
    due_ += kPeriod;
    std::this_thread::sleep_until(due_);
    std::optional<Frame> frame = pool.take(CameraId{0});
    if (!frame) return ReadStatus::Failed;
    frame->sequence = static_cast<std::uint32_t>(given_);
    set.trigger = TriggerNo{given_};
    set.frames[0] = std::move(frame);
    set.live = LiveTimes{due_, StampPoint::EndOfFrame, steady_clock::now(), 1e-3};
    ++ledger_.pulses;
    ++ledger_.cameras[0][FrameFate::Used];
    ++given_;
    return ReadStatus::Ok;
  }
  SourceCounters counters() const noexcept override { return {}; }
  const Ledger* ledger() const noexcept override { return &ledger_; }
  const std::string& problem() const noexcept override { return problem_; }

 private:
  std::uint64_t sets_;
  double rate_hz_;
  std::uint64_t given_ = 0;
  steady_clock::time_point due_ = steady_clock::now();
  std::vector<SourceCamera> cameras_{{"cam1", {64, 48}}};
  Ledger ledger_;
  std::string problem_;
};

struct Seen {
  std::vector<double> ages_s;  // of each tick when its detection was over
  std::vector<std::uint64_t> triggers;
  InputCounters counters;
  Ledger ledger;
};

Seen consume(std::uint64_t sets, double rate_hz, milliseconds work) {
  FrameInputOptions options;
  options.device = "cpu";
  options.detector.depth = 1;
  options.pace = {Pace::Fastest, 0.0};
  FrameInput input(std::make_unique<SteadySource>(sets, rate_hz), std::vector<gpu::Lens>(1), options);
  Seen seen;
  TickBlobs tick;
  while (input.next(tick) == ReadStatus::Ok) {
    EXPECT_TRUE(tick.live);
    EXPECT_EQ(tick.frames, 1u);
    EXPECT_EQ(tick.live->exposed_error_s, 1e-3);
    EXPECT_EQ(tick.live->stamp, StampPoint::EndOfFrame);
    seen.ages_s.push_back(seconds_between(tick.live->arrived, tick.detected));
    seen.triggers.push_back(number(tick.trigger));
    std::this_thread::sleep_for(work);
  }
  seen.counters = input.counters();
  EXPECT_NE(input.ledger(), nullptr);
  seen.ledger = *input.ledger();
  return seen;
}

double median(std::vector<double> values) {
  std::nth_element(values.begin(), values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2),
                   values.end());
  return values[values.size() / 2];
}

TEST(FrameAge, IsBoundedWhereTheConsumerIsSlow) {
  constexpr std::uint64_t kSets = 100;
  const Seen seen = consume(kSets, kRate_hz, 7 * kPeriod / 2);
  // A queue would be as old as it is long: here up to eight periods.
  EXPECT_LE(median(seen.ages_s), 2.0 / kRate_hz);
  EXPECT_TRUE(std::is_sorted(seen.triggers.begin(), seen.triggers.end()));
  EXPECT_GE(seen.ages_s.size(), 20u);
  EXPECT_EQ(seen.ages_s.size() + seen.counters.dropped, kSets);
  const CameraLedger& camera = seen.ledger.cameras[0];
  EXPECT_EQ(camera[FrameFate::Used], seen.ages_s.size());
  EXPECT_EQ(camera[FrameFate::Skipped], seen.counters.dropped);
  EXPECT_TRUE(seen.ledger.balanced());
}

TEST(FrameAge, IsBoundedWhereTheRateIsNotKnown) {
  const Seen seen = consume(60, 0.0, 7 * kPeriod / 2);
  EXPECT_LE(median(seen.ages_s), 3.0 / kRate_hz);
  EXPECT_EQ(seen.ages_s.size() + seen.counters.dropped, 60u);
}

TEST(FrameAge, AQuickConsumerMissesNothing) {
  const Seen seen = consume(40, kRate_hz, milliseconds(0));
  EXPECT_GE(seen.ages_s.size(), 38u) << "dropped " << seen.counters.dropped;
  EXPECT_EQ(seen.ages_s.size() + seen.counters.dropped, 40u);
}

}  // namespace
}  // namespace glint
