// SPDX-License-Identifier: MIT
// Network cameras as one live source.
#pragma once

#include <chrono>
#include <condition_variable>
#include <cstdint>
#include <memory>
#include <mutex>
#include <string>
#include <thread>
#include <vector>

#include "host/capture/image_source.hpp"
#include "host/capture/notes.hpp"
#include "host/frames/source.hpp"

namespace glint {

struct NetworkCamera {
  std::string name, address;
};

/// See open_image_source. One thread per camera decodes into a buffer of its own, so that a slow reader of
/// frame sets never holds up the network, and a stuck camera never holds up the sets.
class NetworkSource final : public FrameSource {
 public:
  /// Opens all cameras at the same time; throws Error that lists every one that failed.
  NetworkSource(const std::vector<NetworkCamera>& cameras, const ImageSourceOptions& options);
  ~NetworkSource() override;

  std::span<const SourceCamera> cameras() const noexcept override { return described_; }
  double rate_hz() const noexcept override { return rate_hz_; }
  bool live() const noexcept override { return true; }
  [[nodiscard]] ReadStatus read(FramePool& pool, FrameSet& set) noexcept override;
  SourceCounters counters() const noexcept override { return counters_; }
  const std::string& problem() const noexcept override { return notes_.text(); }

 private:
  using Clock = std::chrono::steady_clock;
  /// What a camera's thread and the reader of sets exchange.
  struct Camera {
    // Under mutex_:
    std::vector<std::uint8_t> image;  // the newest, if fresh
    Timestamp arrived{};
    std::uint32_t sequence = 0;
    bool opened = false, fresh = false, ended = false;
    std::string problem;  // why opening failed, or why it ended
    FrameSize size;
    double rate_hz = 0.0;
    std::uint64_t replaced = 0, damaged = 0;
    // The reader's own:
    std::vector<std::uint8_t> taken;
    Timestamp taken_arrived{};
    std::uint32_t taken_sequence = 0;
    bool taken_now = false, silence_said = false, end_said = false;
  };
  void run_camera(const std::stop_token& stop, std::size_t index, const std::string& address,
                  double open_timeout_s) noexcept;
  void decode(const std::stop_token& stop, std::size_t index, const std::string& address,
              double open_timeout_s);
  void wait_until_open();
  ReadStatus read_set(FramePool& pool, FrameSet& set);
  bool gather(Timestamp& earliest);
  void copy_frame(std::size_t index, FramePool& pool, FrameSet& set);
  bool any_fresh() const noexcept;
  bool all_ended() const noexcept;
  bool waits_for_more(Timestamp now) const noexcept;

  std::vector<SourceCamera> described_;
  std::vector<Camera> cameras_;
  mutable std::mutex mutex_;
  std::condition_variable changed_;
  double rate_hz_ = 0.0;
  Clock::duration settle_{}, silence_{};
  std::uint64_t sets_ = 0;
  SourceCounters counters_;
  Notes notes_;
  bool failed_ = false;
  std::vector<std::jthread> threads_;  // last: they end before what they use
};

}  // namespace glint
