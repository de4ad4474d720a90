// SPDX-License-Identifier: MIT
// A picture of the board per camera and tick.
#include "host/sim/board_source.hpp"

#include <exception>

#include "host/sim/random.hpp"
#include "host/sim/rig.hpp"

namespace glint {

SimBoardSource::SimBoardSource(const SimOptions& options, sim::PrintedBoard board,
                               const Eigen::AlignedBox2d& area, std::uint64_t views)
    : options_(options), truth_(sim_calibration(options)), board_(std::move(board)), views_(views) {
  for (std::uint32_t c = 0; c < truth_.cameras.size(); ++c) {
    const CameraCalibration& camera = truth_.cameras[c];
    cameras_.push_back({camera.name, {camera.width_px, camera.height_px}});
    poses_.push_back(
        sim::board_poses(camera, area, views, sim::stream_seed(options.seed, sim::Stream::BoardPose, c)));
  }
}

ReadStatus SimBoardSource::read(FramePool& pool, FrameSet& set) noexcept try {
  for (std::optional<Frame>& frame : set.frames) frame.reset();
  if (next_ >= views_) return ReadStatus::End;
  const std::uint64_t tick = next_++;
  set.trigger = TriggerNo{tick};
  for (std::uint32_t c = 0; c < cameras_.size(); ++c) {
    std::optional<Frame> frame = pool.take(CameraId{static_cast<std::uint8_t>(c)});
    if (!frame) {
      ++counters_.no_slot;
      continue;
    }
    sim::board_picture(truth_.cameras[c], poses_[c][tick], board_, options_.sensor,
                       sim::stream_seed(options_.seed, sim::Stream::BoardNoise, c, tick),
                       frame->pixels().data(), frame->stride_bytes());
    frame->sequence = static_cast<std::uint32_t>(tick);
    ++counters_.frames;
    set.frames[c] = std::move(frame);
  }
  return ReadStatus::Ok;
} catch (const std::exception& e) {
  problem_ = e.what();
  return ReadStatus::Failed;
}

}  // namespace glint
