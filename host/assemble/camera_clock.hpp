// SPDX-License-Identifier: MIT
// One camera's clock: which pulse a frame belongs to, from its time stamp and its sequence number.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>

#include "host/assemble/pulse_grid.hpp"

namespace glint {

/// What is known of a frame before its pulse is. Nanoseconds since the assembler's origin; `stamped_ns` may
/// be anything, and is reckoned modulo 2^64.
struct FrameStamp {
  std::int64_t stamped_ns = 0;
  double arrived_s = 0.0;
  std::uint32_t sequence = 0;
};

struct Placement {
  std::int64_t pulse = 0;
  double stamped_s = 0.0;  ///< on the host's clock
  std::int64_t after = 0;  ///< pulse of the frame before
  /// So many frames between the two were counted by the driver and not delivered.
  std::uint64_t lost_by_host = 0;
  /// An earlier frame than the last; it was taken for lost by the host.
  bool out_of_order = false;
  /// Since the frame before, pulses and sequence numbers have advanced alike. If not, there may be a frame
  /// waiting in the camera that was not before, or the other way round.
  bool regular = false;
};

/// First collects stamps, then, once lock()ed to the grid, places frames and follows its offset (stamp minus
/// pulse), the scatter of its stamps, and how long after its stamp a frame arrives.
class CameraClock {
 public:
  static constexpr std::size_t kStamps = 24;   ///< needed to lock
  static constexpr double kMostScatter = 0.2;  ///< of the period, standard deviation, to lock

  explicit CameraClock(double period_s) noexcept;

  /// A stamp to learn from. Stamps more than a second from their arrival are on some other clock, or
  /// jumped: then all are moved so that a frame arrives `usual_latency_s` after its stamp.
  void collect(const FrameStamp& stamp, double usual_latency_s) noexcept;
  std::size_t collected() const noexcept { return collected_; }
  /// Mean stamp minus pulse, modulo the period, of the stamps collected, in -1/2 .. 1/2 period, and their
  /// scatter.
  struct Phase {
    double mean_s = 0.0, scatter_s = 0.0;
  };
  Phase phase(const PulseGrid& grid) const noexcept;
  bool ready(const PulseGrid& grid) const noexcept;
  /// Mean time of the stamps collected.
  double middle_s() const noexcept;
  /// The offset is the one within half a period of `usual_offset_s` (plus what shift() was told).
  void lock(const PulseGrid& grid, double usual_offset_s) noexcept;
  /// Frames are collected from now on.
  void unlock() noexcept;
  bool locked() const noexcept { return locked_; }
  /// Forgets which pulse the last frame had; pulses are numbered anew.
  void forget_numbers() noexcept {
    last_.reset();
    belief_.reset();
  }

  /// Nothing if no pulse is all but certain.
  std::optional<Placement> place(const PulseGrid& grid, const FrameStamp& stamp) noexcept;
  /// What a placed, whole frame says of the grid and of this camera; returns by how much the offset moved.
  double learn(PulseGrid& grid, const Placement& placement, double arrived_s) noexcept;
  /// Frames in a row without a place.
  std::size_t unplaced() const noexcept { return unplaced_; }

  /// See Assembler::shift().
  void shift(const PulseGrid& grid, int pulses) noexcept;
  void move(double by_s) noexcept { offset_s_ += by_s; }
  double offset_s() const noexcept { return offset_s_; }
  double shifted_s(const PulseGrid& grid) const noexcept { return -shift_ * grid.period_s(); }
  double scatter_s() const noexcept;
  double latency_s() const noexcept { return latency_s_; }
  bool latency_known() const noexcept { return latency_known_; }
  bool foreign() const noexcept { return moved_ns_ != 0; }  ///< the stamps are not on the host's clock
  /// When a frame of that pulse should arrive.
  double expected_s(const PulseGrid& grid, std::int64_t pulse) const noexcept;
  /// Pulse of the newest stamp collected.
  std::int64_t newest_collected(const PulseGrid& grid) const noexcept;
  /// The last frame collected is taken for the one before the first to be placed.
  void count_from(const PulseGrid& grid) noexcept;

 private:
  struct Sample {
    double stamped_s = 0.0, latency_s = 0.0;
    std::uint32_t sequence = 0;
  };
  struct Last {
    std::int64_t pulse = 0;
    std::uint32_t sequence = 0;
    std::uint32_t delivered_since = 0;  // frames without a place
  };
  // Which pulse the newest frame had, one after the other from `first`: not normalised. A frame of which the
  // stamp alone does not tell becomes certain with those that follow.
  static constexpr std::size_t kCandidates = 3;
  struct Belief {
    std::int64_t first = 0;
    std::uint32_t sequence = 0;
    std::array<double, kCandidates> weight{};
  };
  double on_host_clock(std::int64_t stamped_ns) const noexcept;
  double prior(std::int64_t pulse, std::uint32_t sequence) const noexcept;
  void learn_scatter(double error_s, double period_s) noexcept;
  double flat_s(double period_s) const noexcept;
  Placement placed(std::int64_t pulse, double stamped_s, std::uint32_t sequence) noexcept;
  std::size_t kept() const noexcept { return collected_ < kStamps ? collected_ : kStamps; }

  std::array<Sample, kStamps> samples_{};
  std::size_t collected_ = 0;
  std::int64_t moved_ns_ = 0;  // added to stamps
  bool locked_ = false, latency_known_ = false;
  double offset_s_ = 0.0, offset_variance_ = 0.0, variance_, latency_s_ = 0.0;
  double slow_variance_ = 0.0, fourth_ = 0.0;  // moments of the errors, for flat_s()
  int shift_ = 0;
  std::optional<Last> last_;  // with a place
  std::optional<Belief> belief_;
  std::int64_t learnt_at_ = 0;  // pulse of the last learn()
  std::size_t unplaced_ = 0;
};

}  // namespace glint
