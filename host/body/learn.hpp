// SPDX-License-Identifier: MIT
// Bodies out of a recording: markers that keep their distances while they move as one.
#pragma once

#include <cstddef>
#include <span>
#include <string>
#include <vector>

#include <Eigen/Core>

#include "host/base/ids.hpp"
#include "host/body/body_model.hpp"

namespace glint {

struct RecordedSample {
  TrackId track{};
  Eigen::Vector3d position_in_world = Eigen::Vector3d::Zero();
};

/// The samples of one exposure; a track is at most once among them.
using RecordedTick = std::vector<RecordedSample>;

struct LearnOptions {
  double max_distance_sd_m = 0.0015;  ///< robust standard deviation of a distance within a body
  double max_diameter_m = 1.0;        ///< of a body
  unsigned min_frames = 50;           ///< in which a marker, and each pair, must have been seen
  double min_turn_rad = 0.26;         ///< a body must have turned by this (15 degrees) ...
  double min_path_m = 0.1;            ///< ... or moved by this: what stands still may be several bodies
  void check(std::vector<std::string>& problems) const;
};

struct LearntBody {
  BodyModel model;
  std::size_t frames = 0;  ///< whose poses it is the mean of
  double scatter_m = 0.0;  ///< of the markers' places in the body, root mean square per axis
  double turn_rad = 0.0;   ///< largest turn between any pose and the first
  double path_m = 0.0;     ///< largest distance from the first
};

struct Learnt {
  std::vector<LearntBody> bodies;    ///< most markers first; named "body1", "body2", ...
  std::vector<std::string> remarks;  ///< what could not be used, and why
};

/// Groups tracks by constant distances, and averages each group over all its poses (alternating between poses
/// and markers until nothing moves). Tracks that never coexist and lie in one place of the body are one
/// marker.
///
/// The frame of a body: origin at the mean of its markers; x towards marker 1, the one farthest from there;
/// the marker farthest from the x axis (marker 2) at positive y with z = 0; z by the right hand. Further
/// markers by their distances from the origin, farthest first. marker_sd_m is the scatter, but at least 0.1
/// mm.
Learnt learn_bodies(std::span<const RecordedTick> ticks, const LearnOptions& options = {});

}  // namespace glint
