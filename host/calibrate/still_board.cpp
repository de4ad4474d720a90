// SPDX-License-Identifier: MIT
// Every camera's own reading of the board is a start; the best one is improved with all cameras held fixed.
#include "host/calibrate/still_board.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <limits>
#include <vector>

#include "host/base/check.hpp"
#include "host/base/error.hpp"
#include "host/calibrate/bundle.hpp"
#include "host/calibrate/pnp.hpp"

namespace glint {
namespace {

constexpr double kStill_m = 0.002, kStill_px = 0.7;  // rms over a view's corners; less than either is noise
constexpr double kFits_px = 3.0;                     // rms: a wrong square or a moved camera is far worse

/// A corner in one camera, averaged over the ticks.
struct MeanCorner {
  Eigen::Vector2d pixel = Eigen::Vector2d::Zero();
  std::size_t ticks = 0;
};

class Placement {
 public:
  Placement(const SampleSet& samples, const Calibration& calibration)
      : samples_(samples), points_(samples.target.points_in_target) {
    GLINT_CHECK(samples.target.kind == TargetKind::Board);
    for (const SampleCamera& wanted : samples.cameras) {
      const auto known =
          std::find_if(calibration.cameras.begin(), calibration.cameras.end(),
                       [&wanted](const CameraCalibration& camera) { return camera.name == wanted.name; });
      if (known == calibration.cameras.end())
        throw Error("the calibration has no camera \"" + wanted.name + "\", which sees the board");
      cameras_.push_back(*known);
    }
    average();
  }

  StillBoard run() const {
    StillBoard board;
    board.cameras = static_cast<std::size_t>(
        std::count_if(corners_.begin(), corners_.end(), [](const std::vector<MeanCorner>& corners) {
          return std::any_of(corners.begin(), corners.end(), [](const MeanCorner& c) { return c.ticks > 0; });
        }));
    board.world_from_board = improved(start());
    board.rms_px = rms_px(board.world_from_board);
    check_still(board.world_from_board);
    if (!(board.rms_px < kFits_px)) {
      char text[200];
      std::snprintf(text, sizeof text,
                    "the board does not fit the calibration (%.1f px rms in %zu cameras): is its size as "
                    "given, and has no camera been moved since?",
                    board.rms_px, board.cameras);
      throw Error(text);
    }
    return board;
  }

 private:
  void average() {
    corners_.assign(cameras_.size(), std::vector<MeanCorner>(points_.size()));
    for (const Sighting& s : samples_.sightings) {
      MeanCorner& corner = corners_[s.camera][s.point];
      corner.pixel += s.pixel;
      ++corner.ticks;
    }
    for (std::vector<MeanCorner>& corners : corners_)
      for (MeanCorner& corner : corners)
        if (corner.ticks > 0) corner.pixel /= static_cast<double>(corner.ticks);
  }

  /// Infinite if the board would lie behind a camera that sees it.
  double rms_px(const Pose& world_from_board) const {
    double squares = 0.0;
    std::size_t count = 0;
    for (std::size_t c = 0; c < cameras_.size(); ++c) {
      const Camera camera(cameras_[c]);
      for (std::size_t p = 0; p < points_.size(); ++p) {
        const MeanCorner& corner = corners_[c][p];
        if (corner.ticks == 0) continue;
        const auto predicted = camera.project(world_from_board * points_[p]);
        if (!predicted) return std::numeric_limits<double>::infinity();
        squares += (*predicted - corner.pixel).squaredNorm();
        ++count;
      }
    }
    return std::sqrt(squares / static_cast<double>(count));
  }

  Pose start() const {
    Pose best;
    double least_px = std::numeric_limits<double>::infinity();
    for (std::size_t c = 0; c < cameras_.size(); ++c) {
      std::vector<Eigen::Vector3d> points;
      std::vector<Eigen::Vector2d> pixels;
      for (std::size_t p = 0; p < points_.size(); ++p) {
        if (corners_[c][p].ticks == 0) continue;
        points.push_back(points_[p]);
        pixels.push_back(corners_[c][p].pixel);
      }
      for (const TargetPose& reading : target_poses(cameras_[c], points, pixels)) {
        const Pose pose = cameras_[c].world_from_camera * reading.camera_from_target;
        const double off_px = rms_px(pose);
        if (!(off_px < least_px)) continue;
        least_px = off_px;
        best = pose;
      }
    }
    if (!std::isfinite(least_px))
      throw Error(
          "no camera sees enough of the board to place it: lay it where two cameras see it, printed side up");
    return best;
  }

  Pose improved(const Pose& world_from_board) const {
    Bundle bundle;
    bundle.target = samples_.target;
    for (const CameraCalibration& c : cameras_)
      bundle.cameras.push_back({intrinsics_of(c), {}, c.world_from_camera.inverse(), true});
    bundle.ticks.push_back({world_from_board, {}});
    for (std::uint32_t c = 0; c < cameras_.size(); ++c)
      for (std::uint32_t p = 0; p < points_.size(); ++p)
        if (corners_[c][p].ticks > 0) bundle.sightings.push_back({c, 0, p, corners_[c][p].pixel});
    BundleOptions options;
    options.schur = false;  // there is nothing but the board to solve for
    adjust(bundle, options);
    return bundle.ticks[0].world_from_target;
  }

  /// How far each view's corners are from where they are on average, at the board's distance.
  void check_still(const Pose& world_from_board) const {
    for (const SampleTick& tick : ticks_of(samples_)) {
      for (std::size_t c = 0; c < cameras_.size(); ++c) {
        double squares = 0.0;
        std::size_t count = 0;
        for (const Sighting& s : tick.sightings) {
          if (s.camera != c) continue;
          squares += (s.pixel - corners_[c][s.point].pixel).squaredNorm();
          ++count;
        }
        if (count == 0) continue;
        const double off_px = std::sqrt(squares / static_cast<double>(count));
        const double distance_m =
            (world_from_board.translation - cameras_[c].world_from_camera.translation).norm();
        const double off_m = off_px * distance_m / cameras_[c].fx_px;
        if (off_px < kStill_px || off_m < kStill_m) continue;
        char text[160];
        std::snprintf(text, sizeof text, ": the board moves, by %.1f mm from its mean place at tick %llu",
                      1e3 * off_m, static_cast<unsigned long long>(tick.tick));
        throw Error(cameras_[c].name + text + "; it must lie still, and the camera must stand still");
      }
    }
  }

  const SampleSet& samples_;
  const std::vector<Eigen::Vector3d>& points_;
  std::vector<CameraCalibration> cameras_;        // in the samples' order
  std::vector<std::vector<MeanCorner>> corners_;  // by camera, then point
};

}  // namespace

StillBoard place_still_board(const SampleSet& samples, const Calibration& calibration) {
  return Placement(samples, calibration).run();
}

}  // namespace glint
