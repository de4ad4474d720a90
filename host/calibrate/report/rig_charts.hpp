// SPDX-License-Identifier: MIT
// Pictures of the whole rig: where cameras stand, how well points will be known, who sees with whom.
#pragma once

#include <span>
#include <string>

#include <Eigen/Core>

#include "host/calibrate/coverage.hpp"
#include "host/calibrate/expected_error.hpp"
#include "host/calibrate/report/plan_view.hpp"
#include "host/geometry/camera.hpp"

namespace glint {

/// Cameras with what they see, and the places of the samples as dots.
std::string layout_svg(PlanAxes axes, const Calibration& calibration,
                       std::span<const Eigen::Vector3d> samples_in_world, const Eigen::Vector3d& low_in_world,
                       const Eigen::Vector3d& high_in_world);

/// A slice in colours, from 0 to `top_m`, with its scale in millimetres and the cameras.
std::string error_slice_svg(PlanAxes axes, const ExpectedErrorMap& map, double top_m,
                            const Calibration& calibration, const Eigen::Vector3d& low_in_world,
                            const Eigen::Vector3d& high_in_world);

/// Cameras in a circle, joined by lines with the number of common ticks; of more than eight cameras, a table
/// in colours.
std::string overlap_svg(const Overlap& overlap, std::span<const std::string> names);

}  // namespace glint
