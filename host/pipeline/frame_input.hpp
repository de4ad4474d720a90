// SPDX-License-Identifier: MIT
// Images in, blobs out: the capture thread, the frame pool and the detector.
#pragma once

#include <array>
#include <atomic>
#include <functional>
#include <memory>
#include <optional>
#include <thread>

#include "gpu/background.hpp"
#include "host/assemble/code_alignment.hpp"
#include "host/assemble/ledger.hpp"
#include "host/base/ring.hpp"
#include "host/capture/pacer.hpp"
#include "host/pipeline/tick_input.hpp"

namespace glint {

struct FrameInputOptions {
  std::string device = "auto";
  gpu::DetectorOptions detector;
  PaceOptions pace;
  std::uint64_t max_sets = 0;               ///< end after so many; 0: at the end of the source
  std::optional<PulseCode> code;            ///< of the pulses in which the light is off; none: it never is
  std::function<void()> on_capture_thread;  ///< called first by that thread; must not throw
};

/// Owns the capture thread: source -> pacing -> ring -> detector, called by the consumer's next().
/// A live source never waits: when the consumer finds a set that came more than two periods ago, it takes the
/// newest there is, and those before are dropped and counted.
class FrameInput final : public TickInput {
 public:
  /// lenses: one per camera of the source. Throws gpu::Error, glint::Error.
  FrameInput(std::unique_ptr<FrameSource> source, std::span<const gpu::Lens> lenses,
             const FrameInputOptions& options);
  ~FrameInput() override;

  /// Until it is set, no pixel of that camera is bright. Before the first next(). Throws gpu::Error.
  void set_background(std::uint32_t camera, gpu::Background background);
  std::span<const SourceCamera> cameras() const noexcept override { return source_->cameras(); }
  bool live() const noexcept override { return source_->live(); }
  double rate_hz() const noexcept override { return source_->rate_hz(); }
  const std::string& device_name() const noexcept override { return detector_->device_name(); }
  [[nodiscard]] ReadStatus next(TickBlobs& tick) noexcept override;
  void stop() noexcept override { stop_.request_stop(); }
  InputCounters counters() const noexcept override;
  const Ledger* ledger() const noexcept override;
  const CodeReport* code() const noexcept override { return alignment_ ? &alignment_->report() : nullptr; }
  std::string problem() const override;
  bool reads_in_place() const noexcept { return in_place_; }

 private:
  void capture() noexcept;
  bool start_capture() noexcept;
  ReadStatus fail() noexcept;
  bool fresh(std::size_t camera, const FrameSet& set) noexcept;
  bool submit_one(bool wait) noexcept;
  bool too_old(const FrameSet& set) const noexcept;
  void drop(const FrameSet& set) noexcept;
  void settle_ledger() noexcept;
  void publish_ledger() noexcept;
  void fill(TickBlobs& tick, const FrameSet& set) noexcept;
  void check_code(TickBlobs& tick, const FrameSet& set) noexcept;

  std::unique_ptr<FrameSource> source_;
  FrameInputOptions options_;
  std::unique_ptr<FramePool> pool_;  // after the source, before the detector that reads from it
  std::unique_ptr<gpu::Detector> detector_;
  bool in_place_ = false;
  Ring<FrameSet> ring_;
  std::vector<FrameSet> in_flight_;  // oldest at in_flight_[oldest_]
  std::size_t oldest_ = 0, count_ = 0;
  std::vector<gpu::ImageView> images_;
  std::vector<gpu::Background> backgrounds_;
  std::vector<std::optional<std::uint32_t>> last_sequence_;  // per camera, of the last frame used
  gpu::BlobBatch batch_;
  std::unique_ptr<CodeAlignment> alignment_;  // if pulses are coded
  bool ended_ = false;
  std::string problem_;
  ReadStatus source_end_ = ReadStatus::End;  // written by the capture thread before it closes the ring
  std::atomic<std::uint64_t> sets_{0}, dropped_{0}, late_{0}, overflows_{0}, copied_{0};
  std::array<std::atomic<std::uint64_t>, gpu::kMaxCameras> not_used_{};        // per camera, in the ledger
  std::array<std::atomic<std::uint64_t>, gpu::kMaxCameras> dropped_frames_{};  // per camera, in dropped sets
  SourceCounters source_counters_;  // written before the ring is closed
  std::optional<Ledger> ledger_;    // likewise; settled by the consumer at the end
  std::atomic<bool> source_done_{false};
  std::stop_source stop_;
  std::thread thread_;  // last: it uses everything above
};

}  // namespace glint
