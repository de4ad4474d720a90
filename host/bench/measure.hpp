// SPDX-License-Identifier: MIT
// Drives one detector over the pictures of a scene and takes the times. In the loops nothing is allocated.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "gpu/detector.hpp"
#include "host/bench/check.hpp"
#include "host/bench/results.hpp"
#include "host/bench/scene.hpp"

namespace glint::bench {

/// A detector and its frames, tick after tick. What is found is counted against what should be, so that an
/// error which only shows under load is seen too.
class Drive {
 public:
  /// All must outlive it; the detector has as many cameras as `expected` was asked for, and the limits set.
  Drive(const Scene& scene, const Expected& expected, gpu::Detector& detector, unsigned cameras);

  /// False: it broke down, see problem(). Never more than `depth` of the detector's options in flight.
  [[nodiscard]] bool submit() noexcept;
  [[nodiscard]] bool collect() noexcept;  ///< of the oldest tick in flight
  [[nodiscard]] bool tick() noexcept { return submit() && collect(); }
  /// Collects what is in flight.
  [[nodiscard]] bool drain() noexcept;

  const gpu::BlobBatch& batch() const noexcept { return batch_; }
  /// Ok, or what went wrong so far and how. Allocates: not for the loops.
  Outcome outcome() const noexcept;
  std::string problem() const;

 private:
  gpu::Detector& detector_;
  std::vector<std::vector<gpu::ImageView>> images_;  // [tick]
  std::vector<std::size_t> found_;                   // [tick], in all cameras
  gpu::BlobBatch batch_;
  std::uint64_t submitted_ = 0, collected_ = 0, wrong_ = 0;
  bool broken_ = false;
};

/// The times of stages by name. add() allocates nothing.
class StageLog {
 public:
  explicit StageLog(std::size_t most_ticks);
  /// `tick` below most_ticks, rising. Stages of one name within a tick are added up.
  void add(std::size_t tick, const std::vector<gpu::StageTime>& stages) noexcept;
  /// In the order in which names appeared. Throws Error if there were more names than room.
  std::vector<StageSeries> series() const;

 private:
  static constexpr std::size_t kMostStages = 32, kLongestName = 63;
  std::size_t most_ticks_, used_ = 0;
  bool full_ = false;
  std::vector<std::string> names_;
  std::vector<double> seconds_;  // [stage][tick]; NaN: did not run
};

/// CPU time of the whole process so far, all threads.
double process_cpu_s() noexcept;

/// One that has run its warm-up, in this order: measure_latency(), measure_throughput(), measure_pace(). Each
/// ends after `ticks` ticks or `max_time_s`. Where drive.outcome() is not Ok afterwards the figures are void.
void warm_up(Drive& drive, const Conditions& conditions);
void measure_latency(Drive& drive, const Conditions& conditions, Row& row);
void measure_throughput(Drive& drive, const Conditions& conditions, Row& row);
/// Ends early once more than `most_late` results took longer than the period.
Paced measure_pace(Drive& drive, const Conditions& conditions, std::size_t most_late = SIZE_MAX);

}  // namespace glint::bench
