// SPDX-License-Identifier: MIT
// Merging of recordings into frame sets.
#include "host/capture/recorded_source.hpp"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <limits>
#include <numeric>
#include <set>
#include <thread>

#include "host/base/check.hpp"
#include "host/base/error.hpp"

namespace glint {
namespace {

constexpr double kRateIfUnknown_hz = 30.0;
constexpr std::chrono::microseconds kSlotPoll{200};
constexpr std::chrono::seconds kLongestWaitForSlot{10};
constexpr double kLargestTime_ns = 4.0e18;  // two of them add up without overflow

std::int64_t to_ns(double time_s) noexcept {
  return static_cast<std::int64_t>(std::clamp(time_s * 1e9, -kLargestTime_ns, kLargestTime_ns));
}

/// A recording can wait: whoever holds the slots is still at work on them.
std::optional<Frame> wait_for_slot(FramePool& pool, CameraId camera) {
  const auto give_up = std::chrono::steady_clock::now() + kLongestWaitForSlot;
  for (;;) {
    if (std::optional<Frame> frame = pool.take(camera)) return frame;
    if (std::chrono::steady_clock::now() > give_up) return std::nullopt;
    std::this_thread::sleep_for(kSlotPoll);
  }
}

}  // namespace

RecordedSource::RecordedSource(std::vector<CameraRecording> cameras, std::optional<FrameLog> log,
                               const std::vector<std::string>& ignored, const ImageSourceOptions& options)
    : log_(std::move(log)) {
  double stored_rate_hz = 0.0;
  for (CameraRecording& camera : cameras) {
    if (log_ && !log_->has_camera(camera.name)) {
      throw Error("frames.csv has no line for camera " + camera.name + "; add its frames or remove the file");
    }
    for (const std::uint64_t frame : camera.recording->numbers()) {
      if (log_ && log_->find(camera.name, frame) == nullptr) {
        throw Error("frames.csv has no line for frame " + std::to_string(frame) + " of camera " +
                    camera.name);
      }
    }
    stored_rate_hz = std::max(stored_rate_hz, camera.recording->rate_hz());
    described_.push_back({camera.name, camera.recording->size()});
    Camera merged;
    merged.recording = std::move(camera.recording);
    cameras_.push_back(std::move(merged));
  }
  rate_hz_ = stored_rate_hz > 0.0 ? stored_rate_hz : options.rate_hz;
  assumed_rate_hz_ = rate_hz_ > 0.0 ? rate_hz_ : kRateIfUnknown_hz;
  for (const std::string& file : ignored) notes_.add(file + ": ignored, its name holds no number");
  find_step();
  for (std::size_t n = 0; n < cameras_.size(); ++n) advance(n);
  const bool timed = std::all_of(cameras_.begin(), cameras_.end(),
                                 [](const Camera& camera) { return camera.head && camera.head->time_ns; });
  if (rate_hz_ == 0.0 && !timed) notes_.add_summary("no frame rate is known: time stamps assume 30 Hz");
}

/// Files may be numbered in steps; the step is the largest number that divides all distances. Videos and
/// logged frames count by one.
void RecordedSource::find_step() {
  if (log_) return;
  std::set<std::uint64_t> all;
  for (const Camera& camera : cameras_) {
    const auto& numbers = camera.recording->numbers();
    if (numbers.empty()) return;
    all.insert(numbers.begin(), numbers.end());
  }
  std::uint64_t step = 0;
  for (const std::uint64_t number : all) step = std::gcd(step, number - *all.begin());
  step_ = std::max<std::uint64_t>(step, 1);
}

/// Finds out what a camera gives next, passing over duplicates.
void RecordedSource::advance(std::size_t index) {
  Camera& camera = cameras_[index];
  const std::string& name = described_[index].name;
  camera.head.reset();
  while (!camera.at_end) {
    const std::optional<std::uint64_t> frame = camera.recording->next_number();
    if (!frame) {
      camera.at_end = true;
      if (!camera.recording->problem().empty()) notes_.add_summary(camera.recording->problem());
      return;
    }
    Head head{*frame, std::nullopt};
    if (log_) {
      const FrameStamp* const stamp = log_->find(name, *frame);
      if (stamp == nullptr) {
        ++counters_.damaged;
        notes_.add("camera " + name + ": frame " + std::to_string(*frame) +
                   " has no line in frames.csv and is left out");
        camera.recording->skip();
        continue;
      }
      head = {stamp->sequence, stamp->time_ns};
    } else if (const std::optional<double> time_s = camera.recording->next_time_s()) {
      head.time_ns = to_ns(*time_s);
    }
    if (camera.last_sequence && head.sequence <= *camera.last_sequence) {
      ++counters_.duplicated;
      camera.recording->skip();
      continue;
    }
    camera.last_sequence = head.sequence;
    camera.head = head;
    return;
  }
}

ReadStatus RecordedSource::read(FramePool& pool, FrameSet& set) noexcept {
  for (auto& frame : set.frames) frame.reset();
  if (failed_) return ReadStatus::Failed;
  if (ended_) return ReadStatus::End;
  try {
    return read_set(pool, set);
  } catch (const std::exception& error) {
    for (auto& frame : set.frames) frame.reset();
    failed_ = true;
    notes_.add_summary(error.what());
    return ReadStatus::Failed;
  }
}

ReadStatus RecordedSource::read_set(FramePool& pool, FrameSet& set) {
  std::optional<std::uint64_t> next;
  for (const Camera& camera : cameras_) {
    if (camera.head && (!next || camera.head->sequence < *next)) next = camera.head->sequence;
  }
  if (!next) {
    ended_ = true;
    sum_up();
    return ReadStatus::End;
  }
  if (last_sequence_) counters_.missing += ((*next - *last_sequence_) / step_ - 1) * cameras_.size();
  last_sequence_ = next;
  ++sets_;

  set.trigger = TriggerNo{*next};
  std::optional<std::int64_t> recorded_ns;
  for (const Camera& camera : cameras_) {
    if (camera.head && camera.head->sequence == *next && !recorded_ns) recorded_ns = camera.head->time_ns;
  }
  set.exposed = exposure_time(*next, recorded_ns);
  for (std::size_t n = 0; n < cameras_.size(); ++n) {
    if (cameras_[n].head && cameras_[n].head->sequence == *next) {
      read_frame(n, pool, set);
    } else {
      ++counters_.missing;
    }
  }
  set.delivered = std::chrono::steady_clock::now();
  return ReadStatus::Ok;
}

void RecordedSource::read_frame(std::size_t index, FramePool& pool, FrameSet& set) {
  Camera& camera = cameras_[index];
  const Head head = *camera.head;
  ++camera.given;
  std::optional<Frame> frame = wait_for_slot(pool, CameraId{static_cast<std::uint8_t>(index)});
  if (!frame) {
    ++counters_.no_slot;
    camera.recording->skip();
  } else {
    const gpu::ImageView slot = frame->image();
    GLINT_CHECK(slot.width_px == described_[index].size.width_px &&
                slot.height_px == described_[index].size.height_px);
    if (camera.recording->take({frame->pixels().data(), slot.stride_bytes, described_[index].size})) {
      frame->sequence = static_cast<std::uint32_t>(head.sequence);
      frame->stamped = head.time_ns ? Timestamp(std::chrono::nanoseconds(*head.time_ns)) : set.exposed;
      frame->stamp = StampPoint::MiddleOfExposure;
      frame->damaged = false;
      set.frames[index] = std::move(frame);
      ++counters_.frames;
    } else {
      ++counters_.damaged;
      notes_.add("camera " + described_[index].name + ": " + camera.recording->problem());
    }
  }
  if (camera.recording->deep() && !said_deep_) {
    said_deep_ = true;
    notes_.add_summary("camera " + described_[index].name +
                       ": images of more than 8 bits are scaled to 8 bits (largest value to 255)");
  }
  advance(index);
}

/// Stored times as they are; between and without them, steps at the nominal rate. Exposures ascend, whatever
/// a single camera's stamps say.
Timestamp RecordedSource::exposure_time(std::uint64_t sequence, std::optional<std::int64_t> recorded_ns) {
  if (recorded_ns || !anchor_) anchor_ = Anchor{sequence, recorded_ns.value_or(0)};
  const double steps = static_cast<double>((sequence - anchor_->sequence) / step_);
  Timestamp exposed(std::chrono::nanoseconds(anchor_->time_ns + to_ns(steps / assumed_rate_hz_)));
  if (last_exposed_ && exposed <= *last_exposed_) exposed = *last_exposed_ + std::chrono::nanoseconds(1);
  last_exposed_ = exposed;
  return exposed;
}

void RecordedSource::sum_up() {
  for (std::size_t n = 0; n < cameras_.size(); ++n) {
    if (!cameras_[n].last_sequence || *cameras_[n].last_sequence < *last_sequence_) {
      ++counters_.ended_early;
      notes_.add_summary("camera " + described_[n].name + " ended after " +
                         std::to_string(cameras_[n].given) + " of " + std::to_string(sets_) + " frames");
    }
  }
}

}  // namespace glint
