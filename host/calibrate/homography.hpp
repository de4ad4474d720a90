// SPDX-License-Identifier: MIT
// The projective map between a plane and its image.
#pragma once

#include <optional>
#include <span>

#include <Eigen/Core>

namespace glint {

/// h with image ~ h * (plane, 1), least squares of the algebraic error in normalised coordinates (Hartley and
/// Zisserman, Multiple View Geometry, 2003, algorithm 4.2). Its sign is such that the mean of the points maps
/// to a positive third coordinate. Nothing for fewer than four points or if all but one lie on a line.
std::optional<Eigen::Matrix3d> find_homography(std::span<const Eigen::Vector2d> plane,
                                               std::span<const Eigen::Vector2d> image);

}  // namespace glint
