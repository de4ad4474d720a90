// SPDX-License-Identifier: MIT
// Every camera of the simulated rig with a person and a board before it, to calibrate its lens.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "host/frames/source.hpp"
#include "host/sim/board_poses.hpp"
#include "host/sim/options.hpp"

namespace glint {

/// Tick n shows each camera its n-th pose of board_poses(). Cameras and lenses are those of the rig with the
/// same options; the boards of different cameras have nothing to do with one another.
class SimBoardSource final : public FrameSource {
 public:
  /// `area` is the board's squares, which are in every view. Throws Error.
  SimBoardSource(const SimOptions& options, sim::PrintedBoard board, const Eigen::AlignedBox2d& area,
                 std::uint64_t views);

  std::span<const SourceCamera> cameras() const noexcept override { return cameras_; }
  double rate_hz() const noexcept override { return 0.0; }
  bool live() const noexcept override { return false; }
  [[nodiscard]] ReadStatus read(FramePool& pool, FrameSet& set) noexcept override;
  SourceCounters counters() const noexcept override { return counters_; }
  const std::string& problem() const noexcept override { return problem_; }

  /// The lenses as they are.
  const Calibration& truth() const noexcept { return truth_; }
  const std::vector<Pose>& poses(std::uint32_t camera) const { return poses_[camera]; }

 private:
  SimOptions options_;
  Calibration truth_;
  sim::PrintedBoard board_;
  std::vector<SourceCamera> cameras_;
  std::vector<std::vector<Pose>> poses_;  // by camera
  std::uint64_t views_, next_ = 0;
  SourceCounters counters_;
  std::string problem_;
};

}  // namespace glint
