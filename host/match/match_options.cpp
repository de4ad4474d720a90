// SPDX-License-Identifier: MIT
// Which settings of the matcher make sense.
#include "host/match/matcher.hpp"

#include <cmath>

namespace glint {

void MatchOptions::check(std::vector<std::string>& problems) const {
  if (!(sigma_px > 0.0)) problems.emplace_back("match.sigma_px must be > 0");
  if (!(exposure_s >= 0.0)) problems.emplace_back("match.exposure_s must be >= 0");
  if (!(gate_px > 0.0)) problems.emplace_back("match.gate_px must be > 0");
  if (gate_px < sigma_px) problems.emplace_back("match.gate_px must not be smaller than match.sigma_px");
  if (min_cameras < 2 || min_cameras > kMatchCameras)
    problems.emplace_back("match.min_cameras must be 2 to 32");
  if (!(marker_radius_m >= 0.0)) problems.emplace_back("match.marker_radius_m must be >= 0 (0: unknown)");
  if (plane_height_m && !(std::abs(*plane_height_m) <= 100.0))
    problems.emplace_back("match.plane_height_m must be -100 to 100");
  if (!(min_range_m > 0.0)) problems.emplace_back("match.min_range_m must be > 0");
  if (!(max_range_m > min_range_m)) problems.emplace_back("match.max_range_m must be > match.min_range_m");
}

std::vector<double> calibration_sd_px(const Calibration& calibration) {
  std::vector<double> sd_px;
  for (const CameraCalibration& camera : calibration.cameras) sd_px.push_back(camera.rms_px / std::sqrt(2.0));
  return sd_px;
}

}  // namespace glint
