// SPDX-License-Identifier: MIT
// How well a bundle adjustment knows its cameras.
#pragma once

#include "host/calibrate/bundle.hpp"
#include "host/calibrate/quality.hpp"

namespace glint {

/// Covariance of the camera parameters at the minimum, the target's places eliminated (the inverse of the
/// Schur complement), for sightings with that standard deviation. Only cameras with a fixed pose have none of
/// their own. With all poses free, the gauge is that of CalibrationUncertainty (inner constraints: Triggs et
/// al. 2000, 9.2).
CalibrationUncertainty uncertainty_of(const Bundle& bundle, const BundleOptions& options, double sigma_px);

}  // namespace glint
