// SPDX-License-Identifier: MIT
// Threads that decode network cameras, and sets made of what they have.
#include "host/capture/network_source.hpp"

#include <algorithm>
#include <chrono>
#include <cstring>

#include "host/base/check.hpp"
#include "host/base/error.hpp"
#include "host/capture/video_decoder.hpp"

namespace glint {
namespace {

using std::chrono::steady_clock;

constexpr std::chrono::seconds kEmptySetAfter{1};
constexpr double kRateIfUnknown_hz = 25.0;
// How long a set waits for the other cameras, in frame periods: cameras that run freely are up to one period
// apart.
constexpr double kSettlePeriods = 1.1;

steady_clock::duration seconds(double s) {
  return std::chrono::duration_cast<steady_clock::duration>(std::chrono::duration<double>(s));
}

std::string with_one_decimal(double value) {
  const std::string text = std::to_string(value);
  return text.substr(0, text.find('.') + 2);
}

}  // namespace

NetworkSource::NetworkSource(const std::vector<NetworkCamera>& cameras, const ImageSourceOptions& options)
    : cameras_(cameras.size()), silence_(seconds(options.silence_s)) {
  for (const NetworkCamera& camera : cameras) described_.push_back({camera.name, {}});
  for (std::size_t n = 0; n < cameras.size(); ++n) {
    threads_.emplace_back([this, n, address = cameras[n].address, timeout_s = options.open_timeout_s](
                              const std::stop_token& stop) { run_camera(stop, n, address, timeout_s); });
  }
  wait_until_open();
  rate_hz_ = options.rate_hz;
  for (std::size_t n = 0; n < cameras_.size(); ++n) {
    const std::lock_guard lock(mutex_);
    described_[n].size = cameras_[n].size;
    if (options.rate_hz <= 0.0) rate_hz_ = std::max(rate_hz_, cameras_[n].rate_hz);
  }
  settle_ = seconds(kSettlePeriods / (rate_hz_ > 0.0 ? rate_hz_ : kRateIfUnknown_hz));
}

NetworkSource::~NetworkSource() {
  for (std::jthread& thread : threads_) thread.request_stop();
}

void NetworkSource::wait_until_open() {
  std::string problems;
  {
    std::unique_lock lock(mutex_);
    changed_.wait(lock, [this] {
      return std::all_of(cameras_.begin(), cameras_.end(),
                         [](const Camera& camera) { return camera.opened || camera.ended; });
    });
    for (std::size_t n = 0; n < cameras_.size(); ++n) {
      if (cameras_[n].opened) continue;
      problems +=
          (problems.empty() ? "camera " : "\ncamera ") + described_[n].name + ": " + cameras_[n].problem;
    }
  }
  if (problems.empty()) return;
  for (std::jthread& thread : threads_) thread.request_stop();
  throw Error(problems);
}

void NetworkSource::run_camera(const std::stop_token& stop, std::size_t index, const std::string& address,
                               double open_timeout_s) noexcept {
  std::string problem;
  try {
    decode(stop, index, address, open_timeout_s);
  } catch (const std::exception& error) {
    problem = error.what();
  }
  const std::lock_guard lock(mutex_);
  if (!problem.empty()) cameras_[index].problem = problem;
  cameras_[index].ended = true;
  changed_.notify_all();
}

void NetworkSource::decode(const std::stop_token& stop, std::size_t index, const std::string& address,
                           double open_timeout_s) {
  VideoDecoder decoder(address, {.live = true, .open_timeout_s = open_timeout_s, .stop = stop});
  const FrameSize size = decoder.size();
  const std::size_t bytes = std::size_t{size.width_px} * size.height_px;
  std::vector<std::uint8_t> image(bytes);
  Camera& camera = cameras_[index];
  {
    const std::lock_guard lock(mutex_);
    camera.size = size;
    camera.rate_hz = decoder.rate_hz();
    camera.image.resize(bytes);
    camera.taken.resize(bytes);
    camera.arrived = steady_clock::now();
    camera.opened = true;
    changed_.notify_all();
  }
  std::uint32_t sequence = 0;
  for (VideoDecoder::Step step;
       !stop.stop_requested() && (step = decoder.next()) != VideoDecoder::Step::End;) {
    const FrameSize now = decoder.size();
    const bool good = step == VideoDecoder::Step::Frame && now.width_px == size.width_px &&
                      now.height_px == size.height_px && decoder.copy_to({image.data(), size.width_px, size});
    const std::lock_guard lock(mutex_);
    if (!good) {
      ++camera.damaged;
    } else {
      if (camera.fresh) ++camera.replaced;
      camera.image.swap(image);
      camera.arrived = steady_clock::now();
      camera.fresh = true;
      camera.sequence = sequence;
      changed_.notify_all();
    }
    ++sequence;
  }
  const std::lock_guard lock(mutex_);
  camera.problem = decoder.problem();
}

bool NetworkSource::any_fresh() const noexcept {
  return std::any_of(cameras_.begin(), cameras_.end(), [](const Camera& camera) { return camera.fresh; });
}

bool NetworkSource::all_ended() const noexcept {
  return std::all_of(cameras_.begin(), cameras_.end(), [](const Camera& camera) { return camera.ended; });
}

/// Whether a camera that is up and has spoken lately has nothing new yet.
bool NetworkSource::waits_for_more(Timestamp now) const noexcept {
  return std::any_of(cameras_.begin(), cameras_.end(), [&](const Camera& camera) {
    return !camera.fresh && !camera.ended && now - camera.arrived < silence_;
  });
}

/// Takes the newest image of each camera that has one; false if there is none and all have hung up.
bool NetworkSource::gather(Timestamp& earliest) {
  std::unique_lock lock(mutex_);
  const bool woken = changed_.wait_for(lock, kEmptySetAfter, [this] { return any_fresh() || all_ended(); });
  if (woken && !any_fresh()) return false;
  if (woken) {
    const auto until = steady_clock::now() + settle_;
    changed_.wait_until(lock, until, [this] { return !waits_for_more(steady_clock::now()); });
  }
  const Timestamp now = steady_clock::now();
  earliest = now;
  counters_.late = counters_.damaged = 0;
  for (std::size_t n = 0; n < cameras_.size(); ++n) {
    Camera& camera = cameras_[n];
    counters_.late += camera.replaced;
    counters_.damaged += camera.damaged;
    camera.taken_now = camera.fresh;
    if (camera.fresh) {
      camera.image.swap(camera.taken);
      camera.taken_sequence = camera.sequence;
      camera.taken_arrived = camera.arrived;
      camera.fresh = camera.silence_said = false;
      earliest = std::min(earliest, camera.arrived);
      continue;
    }
    ++counters_.missing;
    if (camera.ended && !camera.end_said) {
      camera.end_said = true;
      notes_.add("camera " + described_[n].name + " hung up after " + std::to_string(camera.sequence + 1) +
                 " frames" + (camera.problem.empty() ? "" : ": " + camera.problem));
    } else if (!camera.ended && !camera.silence_said && now - camera.arrived >= silence_) {
      camera.silence_said = true;
      notes_.add("camera " + described_[n].name + ": no data for " +
                 with_one_decimal(seconds_between(camera.arrived, now)) + " s");
    }
  }
  return true;
}

void NetworkSource::copy_frame(std::size_t index, FramePool& pool, FrameSet& set) {
  const Camera& camera = cameras_[index];
  std::optional<Frame> frame = pool.take(CameraId{static_cast<std::uint8_t>(index)});
  if (!frame) {
    ++counters_.no_slot;
    return;
  }
  const gpu::ImageView slot = frame->image();
  const FrameSize size = described_[index].size;
  GLINT_CHECK(slot.width_px == size.width_px && slot.height_px == size.height_px);
  std::uint8_t* const pixels = frame->pixels().data();
  for (std::size_t y = 0; y < size.height_px; ++y) {
    std::memcpy(pixels + y * slot.stride_bytes, camera.taken.data() + y * size.width_px, size.width_px);
  }
  frame->stamp = StampPoint::HostArrival;
  frame->damaged = false;
  frame->sequence = camera.taken_sequence;
  frame->stamped = camera.taken_arrived;
  set.frames[index] = std::move(frame);
  ++counters_.frames;
}

ReadStatus NetworkSource::read_set(FramePool& pool, FrameSet& set) {
  Timestamp earliest{};
  if (!gather(earliest)) {
    for (std::size_t n = 0; n < cameras_.size(); ++n) {
      const std::lock_guard lock(mutex_);
      if (!cameras_[n].end_said && !cameras_[n].problem.empty()) {
        cameras_[n].end_said = true;
        notes_.add("camera " + described_[n].name + " hung up: " + cameras_[n].problem);
      }
    }
    return ReadStatus::End;
  }
  set.trigger = TriggerNo{sets_++};
  set.exposed = earliest;
  for (std::size_t n = 0; n < cameras_.size(); ++n) {
    if (cameras_[n].taken_now) copy_frame(n, pool, set);
  }
  set.delivered = steady_clock::now();
  return ReadStatus::Ok;
}

ReadStatus NetworkSource::read(FramePool& pool, FrameSet& set) noexcept {
  for (auto& frame : set.frames) frame.reset();
  if (failed_) return ReadStatus::Failed;
  try {
    return read_set(pool, set);
  } catch (const std::exception& error) {
    for (auto& frame : set.frames) frame.reset();
    failed_ = true;
    notes_.add(error.what());
    return ReadStatus::Failed;
  }
}

}  // namespace glint
