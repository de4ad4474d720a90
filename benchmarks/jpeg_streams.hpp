// SPDX-License-Identifier: MIT
// The simulated rig's cameras as streams of JPEGs in memory.
#pragma once

#include <atomic>
#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "gpu/cpu/workers.hpp"
#include "host/capture/jpeg/jpeg_decoder.hpp"
#include "host/frames/source.hpp"
#include "host/sim/scene.hpp"

namespace glint::benchmarks {

/// Frames of a few ticks, one after the other and back, so that markers never jump.
class JpegPictures {
 public:
  /// Grey JPEGs.
  JpegPictures(const Scene& scene, unsigned ticks, int quality);
  std::span<const std::byte> picture(std::uint64_t n, std::size_t camera) const noexcept;
  std::size_t cameras() const noexcept { return names_.size(); }
  const std::vector<SourceCamera>& described() const noexcept { return names_; }
  double mean_bytes() const noexcept;

 private:
  std::vector<SourceCamera> names_;
  unsigned ticks_;
  std::vector<std::vector<std::byte>> jpegs_;  // tick after tick, camera after camera
};

/// CPU time of the calling thread.
double thread_cpu_s() noexcept;

/// Decodes each camera's pictures on a thread of its own, as live capture does.
class JpegStreams final : public FrameSource {
 public:
  /// paced: a set is begun when it is due at rate_hz, and FrameSet::exposed is that moment; else at once.
  /// whole: decode whole pictures even where a limit is known. `pictures` must outlive the source.
  JpegStreams(const JpegPictures& pictures, std::uint64_t sets, double rate_hz, bool paced, bool whole);

  std::span<const SourceCamera> cameras() const noexcept override { return pictures_.described(); }
  double rate_hz() const noexcept override { return rate_hz_; }
  bool live() const noexcept override { return paced_; }
  void set_limit(std::uint32_t camera, std::span<const std::uint8_t> limit) override;
  [[nodiscard]] ReadStatus read(FramePool& pool, FrameSet& set) noexcept override;
  SourceCounters counters() const noexcept override { return counters_; }
  const std::string& problem() const noexcept override { return problem_; }
  /// All threads, so far.
  double decoding_cpu_s() const noexcept { return static_cast<double>(cpu_ns_.load()) * 1e-9; }

 private:
  static void decode(void* context, unsigned slot, unsigned camera) noexcept;

  const JpegPictures& pictures_;
  std::uint64_t sets_, next_ = 0;
  double rate_hz_;
  bool paced_, whole_;
  Timestamp started_{};
  FrameSet* set_ = nullptr;
  std::vector<JpegDecoder> decoders_;
  std::atomic<std::int64_t> cpu_ns_{0};
  std::atomic<std::uint64_t> bad_{0};
  SourceCounters counters_;
  std::string problem_;
  gpu::Workers workers_;  // last: its threads use everything above
};

}  // namespace glint::benchmarks
