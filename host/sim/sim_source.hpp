// SPDX-License-Identifier: MIT
// The simulated rig as a source of frame sets.
#pragma once

#include <array>
#include <atomic>
#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "host/frames/source.hpp"
#include "host/sim/jpeg_round_trip.hpp"
#include "host/sim/renderer.hpp"
#include "host/sim/scene.hpp"

namespace glint {

struct SimSourceOptions {
  bool live = true;         ///< say so; read() never waits, the caller paces
  std::uint64_t ticks = 0;  ///< sets before the end; 0: endless
};

/// Renders set after set: tick n is TriggerNo n, exposed at start + n / rate. A dropped or late frame is
/// missing in its set and counted; a duplicated frame is delivered with the sequence number of the frame
/// before, and counted. shift() is obeyed as a rig would that had the frames of later pulses waiting.
class SimSource final : public FrameSource {
 public:
  /// `scene` must outlive the source. Throws Error.
  explicit SimSource(const Scene& scene, const SimSourceOptions& options = {});

  /// When tick 0 is exposed; without it, the epoch of the clock.
  void set_start(Timestamp start) noexcept { start_ = start; }
  const Scene& scene() const noexcept { return scene_; }

  std::span<const SourceCamera> cameras() const noexcept override { return cameras_; }
  double rate_hz() const noexcept override { return scene_.options().rate_hz; }
  bool live() const noexcept override { return options_.live; }
  [[nodiscard]] ReadStatus read(FramePool& pool, FrameSet& set) noexcept override;
  void shift(CameraId camera, int pulses) noexcept override {
    wanted_shift_[index(camera)].store(pulses, std::memory_order_relaxed);
  }
  SourceCounters counters() const noexcept override { return counters_; }
  const std::string& problem() const noexcept override { return problem_; }

 private:
  /// One slot of the pool, known by its address.
  struct Buffer {
    const std::uint8_t* pixels = nullptr;
    std::uint64_t fingerprint = 0;  // of what was left there; another one, and someone else wrote to it
    sim::BufferMemory memory;
  };
  Buffer& buffer_at(std::uint32_t camera, const std::uint8_t* pixels);
  std::uint64_t fingerprint(std::span<const std::uint8_t> pixels) const noexcept;
  bool draw(std::uint32_t camera, std::uint64_t tick, Frame& frame);
  std::uint64_t shown(std::uint32_t camera, std::uint64_t frame) const noexcept;

  const Scene& scene_;
  SimSourceOptions options_;
  std::vector<SourceCamera> cameras_;
  sim::Renderer renderer_;
  std::unique_ptr<sim::JpegRoundTrip> jpeg_;
  std::vector<std::vector<Buffer>> buffers_;  // per camera: the pool's slots met so far
  Timestamp start_{};
  std::uint64_t next_tick_ = 0;
  std::array<std::atomic<int>, gpu::kMaxCameras> wanted_shift_{};  // pulses
  std::array<std::uint32_t, gpu::kMaxCameras> run_{};              // Frame::run
  SourceCounters counters_;
  std::string problem_;
};

}  // namespace glint
