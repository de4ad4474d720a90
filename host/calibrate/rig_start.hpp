// SPDX-License-Identifier: MIT
// First poses of all cameras, from pairs of cameras that saw the target together.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include <Eigen/Core>

#include "host/calibrate/samples.hpp"
#include "host/geometry/camera.hpp"

namespace glint {

/// The sightings of a SampleSet on the z = 1 planes of its cameras; nothing where the lens model cannot be
/// inverted.
using PlaneSightings = std::vector<std::optional<Eigen::Vector2d>>;
PlaneSightings undistorted(const SampleSet& samples, const std::vector<CameraCalibration>& cameras);

/// Two cameras, and what is known of how they stand to each other.
struct CameraPair {
  std::uint32_t a = 0, b = 0;
  std::uint64_t ticks = 0;       ///< at which both saw the target
  std::optional<Pose> b_from_a;  ///< to scale, but for a lone marker, where its translation has length 1
  double weight = 0.0;  ///< how far it can be trusted: agreeing ticks, less where rays are nearly parallel
  bool planar = false;  ///< all that both saw lies in one plane, which leaves the pose open
};

struct RigStart {
  std::vector<Pose> camera_from_world;  ///< the world is the first camera's frame
  std::vector<CameraPair> pairs;        ///< all that saw the target together
};

/// Of a marker or a wand by essential matrices, of a board by its poses; joined along the strongest pairs (a
/// maximum spanning tree). Throws Error naming the cameras that are not connected, and why.
RigStart start_rig(const SampleSet& samples, const PlaneSightings& seen,
                   const std::vector<CameraCalibration>& cameras);

/// Whether the target is a wand of two, whose ends nothing tells apart.
bool ends_alike(const Target& target);

/// Of such a wand: renumbers each camera's ends so that all agree within a tick.
void match_ends(SampleSet& samples, PlaneSightings& seen, const std::vector<Pose>& camera_from_world);

}  // namespace glint
