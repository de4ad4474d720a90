// SPDX-License-Identifier: MIT
// What the tracking thread works on: the blobs of one exposure, from images or straight from a file.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "gpu/detector.hpp"
#include "host/assemble/code_alignment.hpp"
#include "host/base/ids.hpp"
#include "host/frames/source.hpp"

namespace glint {

/// Blobs of one exposure; the spans are valid until the next call of next().
struct TickBlobs {
  TriggerNo trigger{};
  Timestamp exposed{};
  Timestamp delivered{};          ///< last byte in host memory
  Timestamp detected{};           ///< blobs in host memory
  std::optional<LiveTimes> live;  ///< as in FrameSet
  std::uint32_t frames = 0;       ///< bit set of cameras whose frame was used; of blob files: all cameras
  bool has_images = false;
  std::vector<std::span<const gpu::BlobRecord>> cameras;
  std::vector<gpu::ImageView> images;  ///< as detected on; only where has_images
  std::uint32_t overflow = 0;          ///< bit set of cameras with more blobs than room
  /// Coded pulses: bit set of cameras that may show another pulse; none: nothing is coded, nothing is known.
  std::optional<std::uint32_t> unproven;
  bool dark = false;  ///< the light was off on purpose: what blobs there are tell nothing of markers
  std::span<const AlignmentEvent> events;
  std::span<const gpu::StageTime> stages;
};

/// Counted since start; what was lost is never silent.
struct InputCounters {
  std::uint64_t sets = 0;       ///< frame sets handed to the tracker
  std::uint64_t dropped = 0;    ///< live only: whole sets dropped, oldest first, because the tracker was
                                ///< behind; in a ledger their frames stand as skipped
  std::uint64_t late = 0;       ///< live only: sets that the source delivered more than one period late
  std::uint64_t overflows = 0;  ///< camera images with more blobs than room
  std::uint64_t copied = 0;     ///< frames that the device could not read in place
  /// Live cameras with a ledger: pulses so far that brought no frame of that camera that was used, dark ones
  /// apart.
  std::array<std::uint64_t, gpu::kMaxCameras> not_used{};
  SourceCounters source;
};

/// One consumer thread calls next() until it says End or Failed.
class TickInput {
 public:
  virtual ~TickInput() = default;
  virtual std::span<const SourceCamera> cameras() const noexcept = 0;
  virtual bool live() const noexcept = 0;
  virtual double rate_hz() const noexcept = 0;
  virtual const std::string& device_name() const noexcept = 0;
  [[nodiscard]] virtual ReadStatus next(TickBlobs& tick) noexcept = 0;
  /// Any thread: end after what is already under way.
  virtual void stop() noexcept = 0;
  virtual InputCounters counters() const noexcept = 0;
  /// After the end, of live cameras: what became of every frame (host/assemble/ledger.hpp); else nullptr.
  virtual const Ledger* ledger() const noexcept { return nullptr; }
  /// After the end: how coded pulses went; nullptr where nothing is coded.
  virtual const CodeReport* code() const noexcept { return nullptr; }
  /// Why next() failed, or what was odd about the source ("" if nothing). After the end.
  virtual std::string problem() const = 0;
};

}  // namespace glint
