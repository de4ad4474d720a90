// SPDX-License-Identifier: MIT
// Rings of frames in, frame sets out.
#include "host/capture/v4l2/v4l2_source.hpp"

#include <algorithm>
#include <chrono>

#include "host/base/error.hpp"

namespace glint {
namespace {

// While nothing comes, the reader is given the chance to stop as often as this.
constexpr std::chrono::milliseconds kIdleAfter{200};
constexpr std::chrono::microseconds kShortestNap{100};
constexpr std::uint32_t kBuffersOfDriver = 6, kSetsBeingMade = 4;

/// `arrived`: of the set's last frame.
LiveTimes live_times(const FrameSet& set, Timestamp arrived, double exposed_error_s) noexcept {
  LiveTimes times;
  times.arrived = arrived;
  times.exposed_error_s = exposed_error_s;
  bool any = false;
  for (const std::optional<Frame>& frame : set.frames) {
    if (!frame || (any && frame->stamped <= times.stamped)) continue;
    times.stamped = frame->stamped;
    times.stamp = frame->stamp;
    any = true;
  }
  return times;
}

std::string times(std::uint64_t count) { return std::to_string(count) + (count == 1 ? " time" : " times"); }

}  // namespace

V4l2Source::V4l2Source(const V4l2Options& options, std::shared_ptr<DeviceCalls> calls)
    : calls_(std::move(calls)), assemble_(options.assemble), pulses_(options.pulses) {
  std::string problems;
  for (const CameraRequest& camera : options.cameras) {
    try {
      feeds_.push_back(std::make_unique<CameraFeed>(*calls_, camera, wake_up_, options.feed));
      described_.push_back({camera.name, feeds_.back()->size()});
    } catch (const Error& error) {
      problems += (problems.empty() ? "" : "\n") + std::string(error.what());
    }
  }
  if (!problems.empty()) throw Error(problems);
  if (feeds_.empty()) throw Error("no camera is named");
  for (const auto& feed : feeds_) {
    if (options.assemble.rate_hz > 0.0 || feed->rate_hz() <= 0.0) continue;
    const bool first = assemble_.rate_hz <= 0.0;
    assemble_.rate_hz = first ? feed->rate_hz() : std::min(assemble_.rate_hz, feed->rate_hz());
  }
  if (assemble_.rate_hz <= 0.0) throw Error("the cameras do not tell their rate: give it (--rate)");
}

V4l2Source::~V4l2Source() { let_go(); }

std::uint32_t V4l2Source::frames_ahead() const noexcept {
  return kBuffersOfDriver + static_cast<std::uint32_t>(CameraFeed::kRing + assemble_.most_sets_waiting) +
         kSetsBeingMade;
}

void V4l2Source::set_limit(std::uint32_t camera, std::span<const std::uint8_t> limit) {
  feeds_[camera]->set_limit(limit);
}

void V4l2Source::start(FramePool& pool) {
  assembler_ = std::make_unique<Assembler>(feeds_.size(), assemble_);
  shifted_.fill(0);
  pool_ = &pool;
  std::string problems;
  for (std::size_t n = 0; n < feeds_.size(); ++n) {
    try {
      feeds_[n]->start(pool, CameraId{static_cast<std::uint8_t>(n)});
    } catch (const std::exception& error) {
      problems += (problems.empty() ? "" : "\n") + std::string(error.what());
    }
  }
  if (!problems.empty()) throw Error(problems);
  if (pulses_ != nullptr) pulses_->begin();
}

void V4l2Source::let_go() noexcept {
  if (pulses_ != nullptr) pulses_->end();
  for (const auto& feed : feeds_) feed->stop();
  assembler_.reset();
  pool_ = nullptr;
}

void V4l2Source::shift(CameraId camera, int pulses) noexcept {
  wanted_shift_[index(camera)].store(pulses, std::memory_order_relaxed);
}

void V4l2Source::apply_shifts() noexcept {
  for (std::size_t n = 0; n < feeds_.size(); ++n) {
    const int wanted = wanted_shift_[n].load(std::memory_order_relaxed);
    if (wanted == shifted_[n]) continue;
    assembler_->shift(CameraId{static_cast<std::uint8_t>(n)}, wanted - shifted_[n]);
    shifted_[n] = wanted;
  }
}

/// Moves everything that has come into the assembler. False if nothing had.
bool V4l2Source::gather() noexcept {
  bool any = false;
  for (FiredPulse pulse; pulses_ != nullptr && pulses_->take(pulse); any = true) {
    assembler_->add_pulse(pulse.trigger, pulse.exposed, pulse.lights_on);
    pulse_error_s_ = pulse.error_s;
  }
  for (std::size_t n = 0; n < feeds_.size(); ++n) {
    const CameraId camera{static_cast<std::uint8_t>(n)};
    for (FeedItem item; feeds_[n]->take(item); any = true) {
      if (item.kind == FeedItem::Kind::Frame) {
        assembler_->add(std::move(item.frame), item.arrived);
      } else {
        assembler_->set_present(camera, item.kind == FeedItem::Kind::Back);
      }
    }
  }
  return any;
}

ReadStatus V4l2Source::read(FramePool& pool, FrameSet& set) noexcept {
  for (auto& frame : set.frames) frame.reset();
  set.live.reset();
  if (!failure_.empty()) return ReadStatus::Failed;
  if (pool_ != &pool) {
    let_go();
    try {
      start(pool);
    } catch (const std::exception& error) {
      failure_ = error.what();
      let_go();
      return ReadStatus::Failed;
    }
  }
  const Timestamp idle_at = std::chrono::steady_clock::now() + kIdleAfter;
  for (;;) {
    apply_shifts();
    const bool any = gather();
    const Timestamp now = std::chrono::steady_clock::now();
    if (assembler_->next(set, now)) {
      set.live = live_times(set, set.delivered, assembler_->exposed_error_s() + pulse_error_s_);
      set.delivered = now;
      return ReadStatus::Ok;
    }
    if (any) continue;  // what came while this was looked at
    if (now >= idle_at) return ReadStatus::Idle;
    const Timestamp due = std::max(assembler_->due().value_or(idle_at), now + kShortestNap);
    wake_up_.wait_until(std::min(idle_at, due));
  }
}

SourceCounters V4l2Source::counters() const noexcept {
  SourceCounters sum;
  if (assembler_) {
    for (const CameraLedger& camera : assembler_->ledger().cameras) {
      sum.frames += camera[FrameFate::Used];
      sum.missing += camera[FrameFate::LostByHost] + camera[FrameFate::LostByCamera];
      sum.damaged += camera[FrameFate::Corrupt];
      sum.late += camera[FrameFate::Late];
      sum.skipped += camera[FrameFate::Skipped];
      sum.duplicated += camera.duplicates;
    }
  }
  for (const auto& feed : feeds_)
    sum.no_slot += feed->counts().flaws[static_cast<std::size_t>(FrameFlaw::NoSlot)];
  return sum;
}

const std::string& V4l2Source::problem() const noexcept {
  try {
    problem_ = failure_.empty() ? odd_things() : failure_;
  } catch (const std::bad_alloc&) {
    problem_.clear();
  }
  return problem_;
}

std::string V4l2Source::odd_things() const {
  constexpr std::array<const char*, kFrameFlaws> kFlawNames{"",
                                                            "flagged by the driver",
                                                            "too short",
                                                            "truncated JPEGs",
                                                            "corrupt JPEGs",
                                                            "of another size",
                                                            "without room in memory",
                                                            "too old to be decoded"};
  std::string text;
  for (const auto& feed : feeds_) {
    const FeedCounts counts = feed->counts();
    std::string line;
    const auto append = [&line](const std::string& part) { line += (line.empty() ? "" : ", ") + part; };
    if (counts.unplugged > 0) append("unplugged " + times(counts.unplugged));
    if (counts.failed > 0) append("failed " + times(counts.failed));
    if (counts.silent > 0) append("silent " + times(counts.silent));
    for (std::size_t n = 1; n < kFrameFlaws; ++n) {
      if (counts.flaws[n] > 0) append(std::to_string(counts.flaws[n]) + " frames " + kFlawNames[n]);
    }
    if (counts.not_taken > 0) append(std::to_string(counts.not_taken) + " frames not taken in time");
    if (!line.empty()) text += (text.empty() ? "camera " : "\ncamera ") + feed->name() + ": " + line;
  }
  return text;
}

}  // namespace glint
