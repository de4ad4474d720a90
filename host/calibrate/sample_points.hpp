// SPDX-License-Identifier: MIT
// Where the target was, as a calibration sees it.
#pragma once

#include <cstddef>
#include <vector>

#include <Eigen/Core>

#include "host/calibrate/samples.hpp"
#include "host/geometry/camera.hpp"

namespace glint {

/// Places of the target's points, each triangulated from all cameras that saw it: at most about `most` of
/// them, evenly over the ticks. The calibration's cameras are the samples', in their order.
std::vector<Eigen::Vector3d> sample_points(const Calibration& calibration, const SampleSet& samples,
                                           std::size_t most = 2000);

}  // namespace glint
