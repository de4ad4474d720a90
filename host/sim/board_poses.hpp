// SPDX-License-Identifier: MIT
// How a person who was told what matters holds a board in front of one camera.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "host/geometry/camera.hpp"
#include "host/sim/board_view.hpp"

namespace glint::sim {

/// camera_from_board of `count` views: near and far, tilted by up to 45 degrees to all sides, and each where
/// the image has seen least of the board so far, up to its corners. All of `area` (the squares) is in each
/// view. Throws Error if the board cannot be held so.
std::vector<Pose> board_poses(const CameraCalibration& camera, const Eigen::AlignedBox2d& area,
                              std::size_t count, std::uint64_t seed);

}  // namespace glint::sim
