// SPDX-License-Identifier: MIT
// Single frames of several cameras in, whole frame sets out, one per pulse.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "host/assemble/ledger.hpp"
#include "host/base/ids.hpp"
#include "host/frames/frame_pool.hpp"

namespace glint {

struct AssembleOptions {
  double rate_hz = 90.0;  ///< nominal rate of the pulses; a few parts in a thousand off is no harm
  std::optional<double> deadline_s{};  ///< how long a set waits for its last camera; none: half a period
  /// Pulses whose frames are held, incomplete ones too; one more, and the oldest is dropped (Skipped).
  std::size_t most_sets_waiting = 8;
  double exposure_s = 0.0;  ///< length of the exposure, for FrameSet::exposed
  /// From the end of the exposure to the stamp where that marks the end of the frame or its arrival
  /// (read-out, transfer). Unknown: taken as 0, and exposed_error_s() grows by a period.
  std::optional<double> readout_s{};
  /// Appends "assemble.rate_hz must be > 0", ...
  void check(std::vector<std::string>& problems) const;
};

/// Pairs frames by pulse, never by arrival or sequence number. A frame's pulse comes from its time stamp: the
/// pulses form a grid whose period and phase are fitted to all cameras' stamps, each camera with an offset
/// of its own; times of the sync board's pulses replace the grid where there is a board. Sequence numbers
/// only tell why a frame is missing: a gap is the host's loss, silence without a gap is the camera's.
///
/// Offsets are known up to whole periods only. They are taken within half a period of the cameras' mean (with
/// a board: of what the stamp marks, see docs/live-capture.md); shift() corrects a camera for which that is
/// wrong. A frame whose pulse is not all but certain is given back and counted as unplaced.
///
/// The first 24 or so frames of each camera only teach the clock (warm_up); no set is made from them, and
/// pulse 0 (with a board: the board's next) is the one after. Thread-bound; nothing is allocated after
/// construction.
class Assembler {
 public:
  /// Throws UsageError when an option is out of range.
  Assembler(std::size_t cameras, const AssembleOptions& options);
  ~Assembler();
  Assembler(const Assembler&) = delete;
  Assembler& operator=(const Assembler&) = delete;

  /// A frame as it came from the driver; frame.camera, .sequence, .stamped, .stamp and .damaged are set.
  /// `arrived` is on the clock of next()'s `now`.
  void add(Frame frame, Timestamp arrived) noexcept;
  /// The camera is gone or silent: sets do not wait for it until it delivers again. All are present at first.
  void set_present(CameraId camera, bool present) noexcept;
  /// The sync board fired pulse `trigger` at that time on the host's clock. Optional; the first call starts
  /// the numbering anew, as the board counts, and so does one that does not go forward (the board was reset).
  /// A frame may be up to 8 periods ahead of its pulse's report. lights_on is heeded when it is known before
  /// the set goes.
  void add_pulse(TriggerNo trigger, Timestamp fired, bool lights_on) noexcept;
  /// Frames of this camera belong to pulses that many later (earlier if negative) than they were taken for,
  /// as coded pulses have shown. Those that it has in sets not taken yet are dropped (Skipped). Adds to
  /// earlier shifts; Frame::shifted is the sum.
  void shift(CameraId camera, int pulses) noexcept;

  /// The next set in order of pulses: complete, or its deadline is over at `now`. Gives back the frames still
  /// in `set` first. False: none is due. Pulses without a usable frame are counted and passed over; dark ones
  /// are handed on with FrameSet::dark, because their pictures prove that all cameras are in step (Dark).
  /// Once the oldest set is more than two periods old, all but the newest that could go are dropped
  /// (Skipped).
  [[nodiscard]] bool next(FrameSet& set, Timestamp now) noexcept;
  /// When next() can give something at the latest without a further frame; none while nothing waits.
  std::optional<Timestamp> due() const noexcept;
  const Ledger& ledger() const noexcept;
  /// Every present camera that has ever delivered has its clock fitted: at least 24 stamps, their scatter
  /// below a fifth of a period, their phase known to a twentieth of one. A camera of which 12 frames in a row
  /// were unplaced has lost that until it is fitted anew.
  bool aligned() const noexcept;
  bool aligned(CameraId camera) const noexcept;
  /// Half-width of an interval about FrameSet::exposed that holds the middle of the exposure: error of the
  /// fit, scatter of the stamps (rounding shifts them one way), disagreement of the cameras, and a period if
  /// it is not known what lies before the stamp. With a board 0: the error of its times is the caller's to
  /// add.
  double exposed_error_s() const noexcept;
  /// Fitted, or measured by the board; nominal until either is known.
  double period_s() const noexcept;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace glint
