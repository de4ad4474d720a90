// SPDX-License-Identifier: MIT
// What a calibration makes of samples: triangulated as the tracker would, without knowing the target's shape.
#pragma once

#include <vector>

#include "host/calibrate/quality.hpp"
#include "host/calibrate/samples.hpp"
#include "host/geometry/camera.hpp"

namespace glint {

/// Triangulates every point that two cameras saw, from those cameras alone, and compares. A tick whose index
/// is held_out() counts as held out if `hold_out`. `outlier` has one flag per sighting, or none at all:
/// flagged ones are counted as outliers and listed where the others place the point, but not used. The
/// calibration's cameras are the samples', in their order.
CalibrationQuality evaluate(const Calibration& calibration, const SampleSet& samples, bool hold_out,
                            const std::vector<std::uint8_t>& outlier = {});

}  // namespace glint
