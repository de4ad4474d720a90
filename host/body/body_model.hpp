// SPDX-License-Identifier: MIT
// A rigid body: where its markers are.
#pragma once

#include <cstddef>
#include <span>
#include <string>
#include <vector>

#include <Eigen/Core>

namespace glint {

inline constexpr std::size_t kBodyMarkers = 32;       ///< of one body, at most
inline constexpr double kLeastMarkerGap_m = 0.01;     ///< nearer markers are one blob as often as two
inline constexpr double kLargestBody_m = 5.0;         ///< larger ones are written in millimetres by mistake
inline constexpr double kDefaultMarkerSd_m = 0.0003;  ///< measured with a ruler or learnt in poor light

struct BodyModel {
  std::string name;
  std::vector<Eigen::Vector3d> markers_in_body;
  double marker_sd_m = kDefaultMarkerSd_m;  ///< how well they are known, per axis

  /// Appends what is wrong: "body.marker_sd_m must be ...", "body.markers_in_body_m must ...".
  void check(std::vector<std::string>& problems) const;
  /// Largest distance between two markers.
  double diameter_m() const noexcept;
};

/// Throws Error with everything that is wrong with any of them, a name that two of them have included.
void check_bodies(std::span<const BodyModel> models);

}  // namespace glint
