// SPDX-License-Identifier: MIT
// The pulses whose sets are not taken yet, and the fates of those before: where every ledger entry is made.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

#include "host/assemble/ledger.hpp"
#include "host/base/ids.hpp"
#include "host/frames/frame_pool.hpp"

namespace glint {

/// Pulses are opened in order of number and retired in that order; a pulse enters the ledger, all cameras at
/// once, when it is retired. Fates of the last kRemembered pulses are kept, so that an entry can still be
/// made right: a missing frame that comes late, or turns out to have been lost by the host.
class SetWindow {
 public:
  static constexpr std::int64_t kRemembered = 256;

  SetWindow(std::size_t cameras, std::size_t most_open);

  /// Counting goes on with this pulse; none is open. What was before can no longer be told from warm-up.
  void begin(std::int64_t first) noexcept;
  /// `pulse` was fired, and all before it. Where that opens too many, the oldest are retired as Skipped.
  void extend(std::int64_t pulse) noexcept;
  /// A frame for a pulse (extend() is called here); kept if it is whole and its pulse is open, else counted
  /// and given back. False if it is no news: a second frame, or of a pulse before begin() or long forgotten.
  bool put(std::int64_t pulse, Frame frame, Timestamp arrived) noexcept;
  /// Of the frames of `camera` missing strictly between two pulses, so many were lost by the host.
  void lost_by_host(CameraId camera, std::int64_t after, std::int64_t before, std::uint64_t count) noexcept;
  /// A frame of that pulse came after a later one, so one frame fewer was lost by the host; which of the
  /// missing ones about it was a guess. Before put().
  void came_after_all(CameraId camera, std::int64_t pulse) noexcept;
  /// Takes the camera's frames out of all open sets; they are Skipped.
  void drop_held(CameraId camera) noexcept;
  void count_unplaced(CameraId camera) noexcept { ++ledger_.cameras[index(camera)].unplaced; }
  void count_warm_up(CameraId camera) noexcept { ++ledger_.cameras[index(camera)].warm_up; }

  bool open() const noexcept { return head_ <= newest_; }
  std::int64_t head() const noexcept { return head_; }             ///< oldest open pulse
  std::int64_t newest() const noexcept { return newest_; }         ///< newest open pulse; head() - 1 if none
  bool lacks(std::int64_t pulse, CameraId camera) const noexcept;  ///< nothing of this open pulse came yet
  bool has_frames(std::int64_t pulse) const noexcept;              ///< at least one frame is held

  /// Retires the oldest open pulse; its held frames end as `held` says, and are moved to `set` if there is
  /// one.
  void retire(FrameFate held, FrameSet* set) noexcept;
  const Ledger& ledger() const noexcept { return ledger_; }

 private:
  FrameFate& fate(std::int64_t pulse, std::size_t camera) noexcept;
  std::optional<Frame>& held(std::int64_t pulse, std::size_t camera) noexcept;
  const std::optional<Frame>& held(std::int64_t pulse, std::size_t camera) const noexcept;
  FrameFate fate(std::int64_t pulse, std::size_t camera) const noexcept;
  void set_fate(std::int64_t pulse, std::size_t camera, FrameFate to) noexcept;
  void count_lost(std::int64_t pulses) noexcept;

  std::size_t cameras_;
  std::int64_t most_open_;
  std::int64_t first_ = 0, head_ = 0, newest_ = -1;
  std::vector<FrameFate> fates_;              // [pulse % kRemembered][camera]; Used: a frame is held
  std::vector<std::optional<Frame>> frames_;  // [pulse % most_open][camera]
  std::vector<Timestamp> delivered_;          // [pulse % most_open]
  Ledger ledger_;
};

}  // namespace glint
