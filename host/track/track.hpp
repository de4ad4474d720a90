// SPDX-License-Identifier: MIT
// What is known of one marker.
#pragma once

#include <array>
#include <cstdint>

#include <Eigen/Core>

#include "host/base/ids.hpp"
#include "host/match/matcher.hpp"
#include "host/track/motion.hpp"
#include "host/track/tracker.hpp"

namespace glint {

struct Track {
  TrackId id;
  Motion motion;
  Eigen::Vector3d measured_at;  ///< last measured position
  double since_measured_s = 0.0;
  unsigned seen = 1, missed = 0;  ///< frames measured by two cameras; frames since any camera saw it
  std::uint32_t age = 0;          ///< frames since two cameras did
  bool published = false;
  std::uint32_t point = kNoPoint;  ///< of this frame
  double brightness = 1.0;         ///< see Prediction
  Eigen::Matrix3d calibration_covariance_m2 = Eigen::Matrix3d::Zero();
  std::array<ViewBias, kMatchCameras> bias{};
};

/// Measured so often, a track is known well enough to live on one camera, and to teach others.
inline constexpr unsigned kSettledFrames = 4;

}  // namespace glint
