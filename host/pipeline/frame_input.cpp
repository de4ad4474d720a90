// SPDX-License-Identifier: MIT
// The capture thread and the detector's side of the ring.
#include "host/pipeline/frame_input.hpp"

#include <algorithm>
#include <bit>

#include "host/base/check.hpp"
#include "host/pipeline/coded_light.hpp"

namespace glint {
namespace {

// A set waits here while the tracker is busy.
constexpr std::size_t kRing = 8;
// Age, since its last frame came, at which a live set gives way to the newest: older results help nobody.
constexpr double kOldestPeriods = 2.0;
constexpr std::size_t kOldestIfRateUnknown = 2;  // sets behind it

std::vector<FrameSize> sizes_of(std::span<const SourceCamera> cameras) {
  std::vector<FrameSize> sizes;
  for (const SourceCamera& camera : cameras) sizes.push_back(camera.size);
  return sizes;
}

std::unique_ptr<gpu::Detector> make(std::span<const SourceCamera> cameras, std::span<const gpu::Lens> lenses,
                                    const FrameInputOptions& options) {
  GLINT_CHECK(lenses.size() == cameras.size());
  std::vector<gpu::CameraFormat> formats;
  for (std::size_t i = 0; i < cameras.size(); ++i) {
    formats.push_back({cameras[i].size.width_px, cameras[i].size.height_px, lenses[i]});
  }
  return gpu::make_detector(options.device, formats, options.detector);
}

}  // namespace

FrameInput::FrameInput(std::unique_ptr<FrameSource> source, std::span<const gpu::Lens> lenses,
                       const FrameInputOptions& options)
    : source_(std::move(source)),
      options_(options),
      // the ring, those in flight, the one being filled, the one popped, and one for the reader at each end
      pool_(std::make_unique<FramePool>(
          sizes_of(source_->cameras()),
          static_cast<std::uint32_t>(kRing + options.detector.depth + 4) + source_->frames_ahead())),
      detector_(make(source_->cameras(), lenses, options)),
      in_place_(detector_->adopt_frame_memory(pool_->memory())),
      ring_(kRing),
      in_flight_(std::max(1u, options.detector.depth)),
      images_(source_->cameras().size()),
      backgrounds_(source_->cameras().size()),
      last_sequence_(source_->cameras().size()) {
  if (options_.code) alignment_ = std::make_unique<CodeAlignment>(*options_.code, source_->cameras().size());
}

FrameInput::~FrameInput() {
  stop_.request_stop();
  ring_.close();
  if (thread_.joinable()) thread_.join();
  gpu::BlobBatch rest;
  while (count_-- > 0) (void)detector_->collect(rest);  // frames in flight are still lent to the device
}

void FrameInput::set_background(std::uint32_t camera, gpu::Background background) {
  detector_->set_limit(camera, background.limit);
  source_->set_limit(camera, background.limit);
  backgrounds_[camera] = std::move(background);
}

void FrameInput::capture() noexcept {
  if (options_.on_capture_thread) options_.on_capture_thread();
  const std::stop_token stop = stop_.get_token();
  const bool is_live = source_->live();
  const double rate = source_->rate_hz();
  Pacer pacer(options_.pace);
  ReadStatus status = ReadStatus::Ok;
  for (std::uint64_t n = 0; !stop.stop_requested() && (options_.max_sets == 0 || n < options_.max_sets);) {
    FrameSet set;
    status = source_->read(*pool_, set);
    if (status == ReadStatus::Idle) continue;
    if (status != ReadStatus::Ok) break;
    ++n;
    publish_ledger();
    if (options_.pace.pace != Pace::Fastest) {
      const double lateness = pacer.wait(pacer.due(set), stop);
      if (is_live && rate > 0.0 && lateness > 1.0 / rate) late_.fetch_add(1, std::memory_order_relaxed);
      if (stop.stop_requested()) break;
    }
    set.delivered = std::chrono::steady_clock::now();
    if (!is_live) {
      if (!ring_.wait_push(std::move(set))) break;
    } else if (!ring_.push(std::move(set))) {
      drop(set);  // the consumer is stuck: it will drop the older ones itself
    }
  }
  source_end_ = status == ReadStatus::Failed ? status : ReadStatus::End;
  source_counters_ = source_->counters();
  if (const Ledger* const ledger = source_->ledger()) ledger_ = *ledger;
  source_->let_go();
  source_done_.store(true, std::memory_order_release);
  ring_.close();
}

// A frame that came again under its old sequence number shows an earlier exposure: it must not be tracked.
bool FrameInput::fresh(std::size_t camera, const FrameSet& set) noexcept {
  const std::optional<Frame>& frame = set.frames[camera];
  if (!frame || frame->damaged || frame->sequence == last_sequence_[camera]) return false;
  last_sequence_[camera] = frame->sequence;
  return true;
}

bool FrameInput::too_old(const FrameSet& set) const noexcept {
  const double rate_hz = source_->rate_hz();
  if (rate_hz <= 0.0) return ring_.size() >= kOldestIfRateUnknown;
  const Timestamp came = set.live ? set.live->arrived : set.delivered;
  return seconds_between(came, std::chrono::steady_clock::now()) > kOldestPeriods / rate_hz;
}

void FrameInput::drop(const FrameSet& set) noexcept {
  dropped_.fetch_add(1, std::memory_order_relaxed);
  if (set.dark) return;  // and that it stays in a ledger
  for (std::size_t camera = 0; camera < images_.size(); ++camera) {
    if (set.frames[camera]) dropped_frames_[camera].fetch_add(1, std::memory_order_relaxed);
  }
}

/// The capture thread, for counters().
void FrameInput::publish_ledger() noexcept {
  const Ledger* const ledger = source_->ledger();
  if (ledger == nullptr) return;
  for (std::size_t camera = 0; camera < ledger->cameras.size(); ++camera) {
    const CameraLedger& entries = ledger->cameras[camera];
    not_used_[camera].store(entries.total() - entries[FrameFate::Used] - entries[FrameFate::Dark],
                            std::memory_order_relaxed);
  }
}

/// The source booked a set as used when it handed it over; those that went no further were skipped by us.
/// After the capture thread has let go of the source.
void FrameInput::settle_ledger() noexcept {
  if (!ledger_) return;
  for (std::size_t camera = 0; camera < ledger_->cameras.size(); ++camera) {
    const std::uint64_t frames = dropped_frames_[camera].exchange(0, std::memory_order_relaxed);
    ledger_->cameras[camera][FrameFate::Used] -= frames;
    ledger_->cameras[camera][FrameFate::Skipped] += frames;
  }
}

bool FrameInput::submit_one(bool wait) noexcept {
  FrameSet set;
  if (!(wait ? ring_.wait_pop(set) : ring_.pop(set))) return false;
  if (source_->live() && too_old(set)) {
    for (FrameSet newer; ring_.pop(newer); set = std::move(newer)) drop(set);
  }
  for (std::size_t i = 0; i < images_.size(); ++i) {
    images_[i] = fresh(i, set) ? set.frames[i]->image() : gpu::ImageView{};
    if (images_[i].pixels == nullptr) set.frames[i].reset();
  }
  if (detector_->submit(images_) != gpu::RunStatus::Ok) {
    problem_ = detector_->last_error();
    return false;
  }
  in_flight_[(oldest_ + count_) % in_flight_.size()] = std::move(set);
  ++count_;
  return true;
}

bool FrameInput::start_capture() noexcept {
  try {
    thread_ = std::thread([this] { capture(); });
    return true;
  } catch (const std::exception& e) {
    problem_ = std::string("no thread for the cameras: ") + e.what();
    ended_ = true;
    return false;
  }
}

// Ends the capture thread and counts what it had delivered in vain.
ReadStatus FrameInput::fail() noexcept {
  stop_.request_stop();
  ring_.close();
  if (thread_.joinable()) thread_.join();
  for (std::size_t n = 0; n < count_; ++n) drop(in_flight_[(oldest_ + n) % in_flight_.size()]);
  for (FrameSet set; ring_.pop(set);) drop(set);
  settle_ledger();
  ended_ = true;
  return ReadStatus::Failed;
}

ReadStatus FrameInput::next(TickBlobs& tick) noexcept {
  if (!thread_.joinable() && !ended_ && !start_capture()) return ReadStatus::Failed;
  // With depth 2 the device is given the next set, if it is there, before the oldest one is waited for.
  while (count_ < in_flight_.size() && problem_.empty() && !ended_) {
    const bool must_wait = count_ == 0;
    if (submit_one(must_wait)) continue;
    if (must_wait && problem_.empty()) ended_ = true;
    break;
  }
  if (!problem_.empty()) return fail();
  if (count_ == 0) {
    settle_ledger();
    return source_end_;
  }
  if (detector_->collect(batch_) != gpu::RunStatus::Ok) {
    problem_ = detector_->last_error();
    return fail();
  }
  tick.detected = std::chrono::steady_clock::now();
  FrameSet& set = in_flight_[oldest_];
  oldest_ = (oldest_ + 1) % in_flight_.size();
  --count_;
  fill(tick, set);
  check_code(tick, set);
  return ReadStatus::Ok;
}

void FrameInput::fill(TickBlobs& tick, const FrameSet& set) noexcept {
  tick.trigger = set.trigger;
  tick.exposed = set.exposed;
  tick.delivered = set.delivered;
  tick.live = set.live;
  tick.frames = 0;
  tick.has_images = true;
  tick.cameras.resize(batch_.cameras.size());
  tick.images.resize(batch_.cameras.size());
  tick.overflow = 0;
  tick.stages = batch_.stages;
  for (std::size_t i = 0; i < batch_.cameras.size(); ++i) {
    tick.cameras[i] = batch_.cameras[i].blobs;
    tick.images[i] = set.frames[i] ? set.frames[i]->image() : gpu::ImageView{};
    if (!backgrounds_[i].mean.empty()) tick.images[i].background = backgrounds_[i].mean.data();
    if (set.frames[i]) tick.frames |= 1u << i;
    if (batch_.cameras[i].overflow) tick.overflow |= 1u << i;
    if (!in_place_ && tick.images[i].pixels != nullptr) copied_.fetch_add(1, std::memory_order_relaxed);
  }
  overflows_.fetch_add(static_cast<std::uint64_t>(std::popcount(tick.overflow)), std::memory_order_relaxed);
  sets_.fetch_add(1, std::memory_order_relaxed);
}

void FrameInput::check_code(TickBlobs& tick, const FrameSet& set) noexcept {
  tick.unproven.reset();
  tick.dark = set.dark;
  tick.events = {};
  if (!alignment_) return;
  check_light(*alignment_, set, tick);
  for (const AlignmentEvent& event : tick.events) {
    if (event.kind == AlignmentEvent::Kind::SlipFound)
      source_->shift(event.camera, alignment_->wanted_shift(event.camera));
  }
}

InputCounters FrameInput::counters() const noexcept {
  InputCounters c;
  c.sets = sets_.load(std::memory_order_relaxed);
  c.dropped = dropped_.load(std::memory_order_relaxed);
  c.late = late_.load(std::memory_order_relaxed);
  c.overflows = overflows_.load(std::memory_order_relaxed);
  c.copied = copied_.load(std::memory_order_relaxed);
  for (std::size_t camera = 0; camera < not_used_.size(); ++camera)
    c.not_used[camera] = not_used_[camera].load(std::memory_order_relaxed);
  if (source_done_.load(std::memory_order_acquire)) c.source = source_counters_;
  return c;
}

const Ledger* FrameInput::ledger() const noexcept {
  return source_done_.load(std::memory_order_acquire) && ledger_ ? &*ledger_ : nullptr;
}

std::string FrameInput::problem() const {
  if (!problem_.empty()) return problem_;
  return source_done_.load(std::memory_order_acquire) ? source_->problem() : std::string();
}

}  // namespace glint
