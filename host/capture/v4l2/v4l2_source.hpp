// SPDX-License-Identifier: MIT
// V4L2 cameras as one live source of frame sets.
#pragma once

#include <array>
#include <atomic>
#include <memory>
#include <string>
#include <vector>

#include "host/assemble/assembler.hpp"
#include "host/assemble/pulse_source.hpp"
#include "host/capture/v4l2/camera_feed.hpp"
#include "host/frames/source.hpp"

namespace glint {

struct V4l2Options {
  std::vector<CameraRequest> cameras;
  AssembleOptions assemble;  ///< rate_hz 0: that of the slowest camera
  FeedOptions feed;
  PulseSource* pulses = nullptr;  ///< the sync board, if there is one; outlives the source
};

/// One thread per camera captures and decodes; read() pairs their frames by pulse. A camera that stops does
/// not stop the others: sets go on without it, feed.on_event says so, and it is taken back when it returns.
class V4l2Source final : public FrameSource {
 public:
  /// Opens all cameras; throws Error with one line for each that failed.
  explicit V4l2Source(const V4l2Options& options,
                      std::shared_ptr<DeviceCalls> calls = std::make_shared<KernelCalls>());
  ~V4l2Source() override;

  std::span<const SourceCamera> cameras() const noexcept override { return described_; }
  double rate_hz() const noexcept override { return assemble_.rate_hz; }
  bool live() const noexcept override { return true; }
  std::uint32_t frames_ahead() const noexcept override;
  void set_limit(std::uint32_t camera, std::span<const std::uint8_t> limit) override;
  /// The first call with a pool starts the cameras: frames come straight out of it until let_go().
  [[nodiscard]] ReadStatus read(FramePool& pool, FrameSet& set) noexcept override;
  void let_go() noexcept override;
  void shift(CameraId camera, int pulses) noexcept override;
  SourceCounters counters() const noexcept override;
  const Ledger* ledger() const noexcept override { return assembler_ ? &assembler_->ledger() : nullptr; }
  const std::string& problem() const noexcept override;

 private:
  void start(FramePool& pool);
  bool gather() noexcept;
  void apply_shifts() noexcept;
  std::string odd_things() const;

  std::shared_ptr<DeviceCalls> calls_;
  AssembleOptions assemble_;
  PulseSource* pulses_;
  double pulse_error_s_ = 0.0;  // of the newest
  std::vector<SourceCamera> described_;
  WakeUp wake_up_;
  FramePool* pool_ = nullptr;  // that the cameras fill
  std::unique_ptr<Assembler> assembler_;
  std::array<std::atomic<int>, gpu::kMaxCameras> wanted_shift_{};  // pulses, of shift()
  std::array<int, gpu::kMaxCameras> shifted_{};                    // what the assembler was told of it
  std::vector<std::unique_ptr<CameraFeed>> feeds_;                 // after what their threads use
  std::string failure_;
  mutable std::string problem_;
};

}  // namespace glint
