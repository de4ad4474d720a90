// SPDX-License-Identifier: MIT
// A rig with coded pulses from stamps to points: simulated deliveries and blobs through the real assembler,
// alignment, matcher and tracker.
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <optional>
#include <random>
#include <string>
#include <vector>

#include "host/pipeline/track_pipeline.hpp"
#include "host/sim/scene.hpp"
#include "tests/unit/assemble/simulated_rig.hpp"

namespace glint::testing {

struct CodedRigOptions {
  SimOptions scene;  ///< markers, cameras, rate and code; its own faults are not used
  RigOptions rig;    ///< deliveries; rate and cameras are the scene's
  /// Blobs of camera `camera` vanish in these exposures although the light is on.
  struct Blackout {
    std::uint32_t camera = 0;
    std::int64_t from = 0, to = 0;
  };
  std::vector<Blackout> blackouts;
};

/// What each camera's frame of a set showed; -1: it had none.
using ShownExposures = std::array<std::int64_t, 8>;

/// Frames carry the exposure that they show instead of pixels; its blobs are projected from the scene's
/// truth. A shift reaches the assembler three sets after it was asked for.
class CodedRig final : public TickInput {
 public:
  explicit CodedRig(const CodedRigOptions& options, const Scene& scene);

  std::span<const SourceCamera> cameras() const noexcept override { return described_; }
  bool live() const noexcept override { return false; }
  double rate_hz() const noexcept override { return options_.scene.rate_hz; }
  const std::string& device_name() const noexcept override { return name_; }
  [[nodiscard]] ReadStatus next(TickBlobs& tick) noexcept override;
  void stop() noexcept override {}
  InputCounters counters() const noexcept override { return {}; }
  const CodeReport* code() const noexcept override { return &alignment_.report(); }
  std::string problem() const override { return {}; }

  /// Of a set that was handed on; any thread that has its result.
  const ShownExposures& shown(TriggerNo trigger) const { return shown_.at(number(trigger)); }
  const Ledger* ledger() const noexcept override { return &assembler_.ledger(); }

 private:
  bool next_set();
  void deliver(const Delivery& delivery);
  void make_blobs(std::uint32_t camera, std::int64_t exposure, std::vector<gpu::BlobRecord>& blobs);
  const TickTruth& truth(std::int64_t exposure);
  void shift_when_due();

  CodedRigOptions options_;
  const Scene& scene_;
  SimulatedRig rig_;
  FramePool pool_;
  FrameSet set_;  // after the pool
  Assembler assembler_;
  CodeAlignment alignment_;
  std::vector<SourceCamera> described_;
  std::string name_ = "none (coded rig)";
  std::size_t delivered_ = 0;
  double clock_s_ = 0.0;
  std::vector<std::vector<gpu::BlobRecord>> blobs_;
  std::vector<ShownExposures> shown_;  // by trigger
  std::vector<std::optional<TickTruth>> truths_;
  std::mt19937_64 random_;
  struct Request {
    CameraId camera{};
    int pulses = 0, sets_left = 0;
  };
  std::optional<Request> request_;
  std::array<int, 8> shifted_{};
};

}  // namespace glint::testing
