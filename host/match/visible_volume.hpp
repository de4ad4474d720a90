// SPDX-License-Identifier: MIT
// How much space the rig looks at: the prior density of a marker that nobody predicted.
#pragma once

#include <span>

#include "host/geometry/camera.hpp"

namespace glint {

/// Volume in m^3 that at least two cameras see between the ranges, by summing over samples of the views; at
/// least a little, so that its logarithm can be taken.
double visible_volume_m3(std::span<const Camera> cameras, double min_range_m, double max_range_m);

/// Inside the image with its lens, and within the ranges.
bool sees(const Camera& camera, const Eigen::Vector3d& point_in_world, double margin_px, double min_range_m,
          double max_range_m) noexcept;

}  // namespace glint
