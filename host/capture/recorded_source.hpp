// SPDX-License-Identifier: MIT
// Recordings of several cameras, merged into frame sets by number.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "host/capture/frame_log.hpp"
#include "host/capture/image_source.hpp"
#include "host/capture/notes.hpp"
#include "host/capture/recording.hpp"
#include "host/frames/source.hpp"

namespace glint {

struct CameraRecording {
  std::string name;
  std::unique_ptr<Recording> recording;
};

/// See open_image_source. A set is made for every exposure that at least one camera has.
class RecordedSource final : public FrameSource {
 public:
  /// `log` may be absent; `ignored` are files to report. Throws Error.
  RecordedSource(std::vector<CameraRecording> cameras, std::optional<FrameLog> log,
                 const std::vector<std::string>& ignored, const ImageSourceOptions& options);

  std::span<const SourceCamera> cameras() const noexcept override { return described_; }
  double rate_hz() const noexcept override { return rate_hz_; }
  bool live() const noexcept override { return false; }
  [[nodiscard]] ReadStatus read(FramePool& pool, FrameSet& set) noexcept override;
  SourceCounters counters() const noexcept override { return counters_; }
  const std::string& problem() const noexcept override { return notes_.text(); }

 private:
  /// The frame that a camera gives next.
  struct Head {
    std::uint64_t sequence = 0;
    std::optional<std::int64_t> time_ns;
  };
  struct Camera {
    std::unique_ptr<Recording> recording;
    std::optional<Head> head;
    std::optional<std::uint64_t> last_sequence;
    std::uint64_t given = 0;  // frames, damaged ones too
    bool at_end = false;
  };
  /// A stored time, or the start.
  struct Anchor {
    std::uint64_t sequence = 0;
    std::int64_t time_ns = 0;
  };
  ReadStatus read_set(FramePool& pool, FrameSet& set);
  void advance(std::size_t index);
  void read_frame(std::size_t index, FramePool& pool, FrameSet& set);
  Timestamp exposure_time(std::uint64_t sequence, std::optional<std::int64_t> recorded_ns);
  void sum_up();
  void find_step();

  std::vector<SourceCamera> described_;
  std::vector<Camera> cameras_;
  std::optional<FrameLog> log_;
  double rate_hz_ = 0.0, assumed_rate_hz_ = 0.0;
  std::uint64_t step_ = 1;
  std::optional<std::uint64_t> last_sequence_;
  std::optional<Anchor> anchor_;
  std::optional<Timestamp> last_exposed_;
  std::uint64_t sets_ = 0;
  SourceCounters counters_;
  Notes notes_;
  bool ended_ = false, failed_ = false, said_deep_ = false;
};

}  // namespace glint
