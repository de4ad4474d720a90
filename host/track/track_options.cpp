// SPDX-License-Identifier: MIT
// Which settings of the tracker make sense.
#include "host/track/tracker.hpp"

namespace glint {

void TrackOptions::check(std::vector<std::string>& problems) const {
  if (!(acceleration_sd_m_s2 > 0.0)) problems.emplace_back("track.acceleration_sd_m_s2 must be > 0");
  if (!(max_speed_m_s > 0.0)) problems.emplace_back("track.max_speed_m_s must be > 0");
  if (confirm_frames_two_views < 1) problems.emplace_back("track.confirm_frames_two_views must be >= 1");
  if (!(max_predicted_sd_m >= 0.0)) problems.emplace_back("track.max_predicted_sd_m must be >= 0");
}

}  // namespace glint
