// SPDX-License-Identifier: MIT
// Where frame sets and blob sets come from: cameras, recordings, the simulator.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "gpu/detector.hpp"
#include "host/base/ids.hpp"
#include "host/frames/frame_pool.hpp"

namespace glint {

struct Ledger;

struct SourceCamera {
  std::string name;
  FrameSize size;  ///< 0x0 where the source has no images
};

/// What a source lost or found broken, counted since its start.
struct SourceCounters {
  std::uint64_t frames = 0, missing = 0, damaged = 0, late = 0, duplicated = 0, no_slot = 0;
  std::uint64_t skipped = 0;      ///< live: whole sets left out because the reader was behind
  std::uint64_t ended_early = 0;  ///< recordings: cameras that ended before others
};

enum class ReadStatus : std::uint8_t {
  Ok,
  Idle,    ///< live frame sources: nothing has come for a while; read again
  End,     ///< nothing more will come
  Failed,  ///< problem() says what; nothing more will come
};

/// Gives whole frame sets in order of exposure. Thread-bound.
class FrameSource {
 public:
  virtual ~FrameSource() = default;
  virtual std::span<const SourceCamera> cameras() const noexcept = 0;
  /// Nominal frame sets per second; 0 if unknown.
  virtual double rate_hz() const noexcept = 0;
  /// Live sources cannot wait: what is not taken in time is lost. Recordings wait.
  virtual bool live() const noexcept = 0;
  /// Fills `set` with the next exposure: its frames are taken from `pool`. Frames still in `set` are given
  /// back first. A camera without a (usable) frame is left empty and counted. May block.
  [[nodiscard]] virtual ReadStatus read(FramePool& pool, FrameSet& set) noexcept = 0;
  /// What becomes of that camera's pictures: only pixels above `limit` (width * height, rows without gaps,
  /// borrowed for the call) matter from the next read() on. A source that decodes may spare itself the
  /// others, which may then have any value that is not above it. Not while it gives frames: before the first
  /// read(), or after let_go(). Throws std::bad_alloc.
  virtual void set_limit(std::uint32_t /*camera*/, std::span<const std::uint8_t> /*limit*/) {}
  /// Frames of each camera that the source keeps for itself between reads: a pool must have room for them
  /// beside those that the reader holds.
  virtual std::uint32_t frames_ahead() const noexcept { return 0; }
  /// Gives back what it keeps of the pool that read() had last, so that the pool may end; reading on, with
  /// any pool, is possible, and counts from nothing where a ledger is kept. To be called before a pool ends.
  virtual void let_go() noexcept {}
  /// Any thread, without waiting: from now on frames of this camera belong to pulses `pulses` later than its
  /// time stamps say (earlier if negative), as coded pulses have shown. Not added to what was asked before:
  /// it replaces that. Frame::shifted tells which frames it has reached; sources that cannot do it leave that
  /// 0.
  virtual void shift(CameraId camera, int pulses) noexcept {
    (void)camera;
    (void)pulses;
  }
  virtual SourceCounters counters() const noexcept = 0;
  /// What became of every frame of every pulse, where that is known (host/assemble/ledger.hpp); else nullptr.
  /// Valid until the next read() or let_go().
  virtual const Ledger* ledger() const noexcept { return nullptr; }
  /// Why read() failed or what was odd about the source at its end ("" if nothing), for the person at the
  /// terminal.
  virtual const std::string& problem() const noexcept = 0;
};

/// Blobs of one exposure, all cameras. Undistorted fields are filled by whoever knows the calibration.
struct BlobSet {
  TriggerNo trigger{};
  Timestamp exposed{};
  Timestamp delivered{};
  std::vector<std::vector<gpu::BlobRecord>> cameras;
};

/// Gives blob sets instead of images: other tools' 2D points. Thread-bound.
class BlobSource {
 public:
  virtual ~BlobSource() = default;
  virtual std::span<const SourceCamera> cameras() const noexcept = 0;
  [[nodiscard]] virtual ReadStatus read(BlobSet& set) noexcept = 0;
  virtual const std::string& problem() const noexcept = 0;
};

}  // namespace glint
