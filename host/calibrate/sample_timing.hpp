// SPDX-License-Identifier: MIT
// Whether the sightings of a tick are really of the same moment.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "host/calibrate/samples.hpp"
#include "host/geometry/camera.hpp"

namespace glint {

struct CameraTiming {
  double delay_s = 0.0;     ///< its images are that much later than the mean of all cameras
  double delay_sd_s = 0.0;  ///< standard deviation of that
};

struct SampleTiming {
  std::vector<CameraTiming> cameras;
  double jitter_s = 0.0;  ///< by which the cameras' moments differ from tick to tick beyond the delays, rms
  double jitter_sd_s = 0.0;
  std::uint64_t sightings = 0;  ///< that it follows from
};

/// A target that moves is seen where it was at each camera's own moment: residuals along its image's velocity
/// tell the delays (least squares of r_k = v_k d_k - J_k (sum J'J)^-1 sum J'_j v_j d_j over all points, as
/// triangulation shares every delay among its views), and residuals that grow with the speed either way tell
/// irregular moments. Nothing where the rate is unknown, the target stood still or too little was seen.
std::optional<SampleTiming> timing_of(const Calibration& calibration, const SampleSet& samples);

/// What to tell the person; empty where all is well.
std::vector<std::string> timing_sentences(const SampleTiming& timing, const Calibration& calibration);

}  // namespace glint
