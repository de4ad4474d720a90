// SPDX-License-Identifier: MIT
// Open sets in one ring, fates in a longer one.
#include "host/assemble/set_window.hpp"

#include <algorithm>
#include <utility>

#include "host/base/check.hpp"

namespace glint {
namespace {

constexpr std::int64_t kNear = 16;  // pulses; a frame is not overtaken by more

bool missing(FrameFate fate) noexcept {
  return fate == FrameFate::LostByCamera || fate == FrameFate::LostByHost;
}

}  // namespace

SetWindow::SetWindow(std::size_t cameras, std::size_t most_open)
    : cameras_(cameras), most_open_(static_cast<std::int64_t>(most_open)) {
  GLINT_CHECK(cameras > 0 && most_open > 0 && most_open_ < kRemembered);
  fates_.resize(cameras * static_cast<std::size_t>(kRemembered), FrameFate::LostByCamera);
  frames_.resize(cameras * most_open);
  delivered_.resize(most_open);
  ledger_.cameras.resize(cameras);
}

FrameFate& SetWindow::fate(std::int64_t pulse, std::size_t camera) noexcept {
  return fates_[static_cast<std::size_t>(pulse % kRemembered) * cameras_ + camera];
}

FrameFate SetWindow::fate(std::int64_t pulse, std::size_t camera) const noexcept {
  return fates_[static_cast<std::size_t>(pulse % kRemembered) * cameras_ + camera];
}

std::optional<Frame>& SetWindow::held(std::int64_t pulse, std::size_t camera) noexcept {
  return frames_[static_cast<std::size_t>(pulse % most_open_) * cameras_ + camera];
}

const std::optional<Frame>& SetWindow::held(std::int64_t pulse, std::size_t camera) const noexcept {
  return frames_[static_cast<std::size_t>(pulse % most_open_) * cameras_ + camera];
}

void SetWindow::begin(std::int64_t first) noexcept {
  GLINT_CHECK(!open() && first >= 0);
  first_ = head_ = first;
  newest_ = first - 1;
}

void SetWindow::extend(std::int64_t pulse) noexcept {
  while (open() && pulse - head_ >= most_open_) retire(FrameFate::Skipped, nullptr);
  if (!open()) count_lost(pulse - most_open_ + 1 - head_);
  while (newest_ < pulse) {
    ++newest_;
    for (std::size_t camera = 0; camera < cameras_; ++camera) fate(newest_, camera) = FrameFate::LostByCamera;
    delivered_[static_cast<std::size_t>(newest_ % most_open_)] = {};
  }
}

/// The next pulses, of which nobody delivered anything, at once: after a pause there may be millions.
void SetWindow::count_lost(std::int64_t pulses) noexcept {
  if (pulses <= 0) return;
  const auto count = static_cast<std::uint64_t>(pulses);
  ledger_.pulses += count;
  for (CameraLedger& camera : ledger_.cameras) camera[FrameFate::LostByCamera] += count;
  head_ += pulses;
  newest_ = head_ - 1;
  for (std::int64_t pulse = std::max(head_ - pulses, head_ - kRemembered); pulse < head_; ++pulse) {
    for (std::size_t camera = 0; camera < cameras_; ++camera) fate(pulse, camera) = FrameFate::LostByCamera;
  }
}

void SetWindow::set_fate(std::int64_t pulse, std::size_t camera, FrameFate to) noexcept {
  FrameFate& entry = fate(pulse, camera);
  if (pulse < head_) {
    CameraLedger& ledger = ledger_.cameras[camera];
    --ledger[entry];
    ++ledger[to];
  }
  entry = to;
}

bool SetWindow::put(std::int64_t pulse, Frame frame, Timestamp arrived) noexcept {
  const std::size_t camera = index(frame.camera);
  CameraLedger& ledger = ledger_.cameras[camera];
  if (pulse < first_) {
    ++ledger.warm_up;
    return false;
  }
  extend(pulse);
  if (pulse <= newest_ - kRemembered) {
    ++ledger.unplaced;
    return false;
  }
  if (!missing(fate(pulse, camera))) {
    ++ledger.duplicates;
    return false;
  }
  if (frame.damaged) {
    set_fate(pulse, camera, FrameFate::Corrupt);
  } else if (pulse < head_) {
    set_fate(pulse, camera, FrameFate::Late);
  } else {
    set_fate(pulse, camera, FrameFate::Used);
    held(pulse, camera) = std::move(frame);
    Timestamp& delivered = delivered_[static_cast<std::size_t>(pulse % most_open_)];
    delivered = std::max(delivered, arrived);
  }
  return true;
}

void SetWindow::lost_by_host(CameraId camera, std::int64_t after, std::int64_t before,
                             std::uint64_t count) noexcept {
  std::int64_t pulse = std::max(after + 1, first_);
  const std::int64_t remembered = std::max(pulse, newest_ - kRemembered + 1);
  CameraLedger& ledger = ledger_.cameras[index(camera)];
  // Pulses that are forgotten: the camera delivered nothing in between, so they stand as lost by the camera.
  const auto forgotten = std::min({count, static_cast<std::uint64_t>(std::min(remembered, before) - pulse),
                                   ledger[FrameFate::LostByCamera]});
  ledger[FrameFate::LostByCamera] -= forgotten;
  ledger[FrameFate::LostByHost] += forgotten;
  count -= forgotten;
  for (pulse = remembered; pulse < before && count > 0; ++pulse) {
    if (fate(pulse, index(camera)) != FrameFate::LostByCamera) continue;
    set_fate(pulse, index(camera), FrameFate::LostByHost);
    --count;
  }
}

void SetWindow::came_after_all(CameraId camera, std::int64_t pulse) noexcept {
  const std::int64_t oldest = std::max(first_, newest_ - kRemembered + 1);
  if (pulse < oldest || pulse > newest_ || fate(pulse, index(camera)) != FrameFate::LostByCamera) return;
  for (std::int64_t distance = 1; distance <= kNear; ++distance) {
    for (const std::int64_t other : {pulse - distance, pulse + distance}) {
      if (other < oldest || other > newest_ || fate(other, index(camera)) != FrameFate::LostByHost) continue;
      set_fate(other, index(camera), FrameFate::LostByCamera);
      return;
    }
  }
}

void SetWindow::drop_held(CameraId camera) noexcept {
  for (std::int64_t pulse = head_; pulse <= newest_; ++pulse) {
    std::optional<Frame>& frame = held(pulse, index(camera));
    if (!frame) continue;
    frame.reset();
    set_fate(pulse, index(camera), FrameFate::Skipped);
  }
}

bool SetWindow::lacks(std::int64_t pulse, CameraId camera) const noexcept {
  return missing(fate(pulse, index(camera)));
}

bool SetWindow::has_frames(std::int64_t pulse) const noexcept {
  for (std::size_t camera = 0; camera < cameras_; ++camera) {
    if (held(pulse, camera)) return true;
  }
  return false;
}

void SetWindow::retire(FrameFate held_fate, FrameSet* set) noexcept {
  GLINT_CHECK(open());
  for (std::size_t camera = 0; camera < cameras_; ++camera) {
    FrameFate& entry = fate(head_, camera);
    std::optional<Frame>& frame = held(head_, camera);
    if (entry == FrameFate::Used) entry = held_fate;
    ++ledger_.cameras[camera][entry];
    if (frame && set != nullptr) set->frames[camera] = std::move(frame);
    frame.reset();
  }
  if (set != nullptr) set->delivered = delivered_[static_cast<std::size_t>(head_ % most_open_)];
  ++ledger_.pulses;
  ++head_;
}

}  // namespace glint
