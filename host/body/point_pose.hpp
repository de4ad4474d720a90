// SPDX-License-Identifier: MIT
// The pose that takes known points to measured ones, in closed form.
#pragma once

#include <array>
#include <optional>
#include <span>

#include "host/geometry/pose.hpp"

namespace glint {

/// Least squares over three or more points that do not lie on a line, never mirrored (Kabsch 1978; Umeyama,
/// PAMI 13, 1991). `weights` may be empty: all alike. Nothing if the points leave a turn undetermined. Does
/// not allocate.
std::optional<Pose> pose_from_points(std::span<const Eigen::Vector3d> points_in_b,
                                     std::span<const Eigen::Vector3d> points_in_a,
                                     std::span<const double> weights = {}) noexcept;

/// Root mean square distance between a_from_b * points_in_b and points_in_a.
double rms_distance(const Pose& a_from_b, std::span<const Eigen::Vector3d> points_in_b,
                    std::span<const Eigen::Vector3d> points_in_a) noexcept;

/// The pose of two triples of points whose sides agree: first point on first point, as well as it goes for
/// the others. Cheaper than pose_from_points(); nothing if either lies on a line.
std::optional<Pose> pose_from_triple(const std::array<Eigen::Vector3d, 3>& in_b,
                                     const std::array<Eigen::Vector3d, 3>& in_a) noexcept;

}  // namespace glint
