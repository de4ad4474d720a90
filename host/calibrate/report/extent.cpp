// SPDX-License-Identifier: MIT
// What part of the world a report's pictures show.
#include "host/calibrate/report/extent.hpp"

#include <algorithm>
#include <vector>

namespace glint {

ReportExtent report_extent(const Calibration& calibration,
                           std::span<const Eigen::Vector3d> samples_in_world) {
  ReportExtent extent;
  bool any = false;
  const auto include = [&](const Eigen::Vector3d& p) {
    extent.low_in_world = any ? extent.low_in_world.cwiseMin(p).eval() : p;
    extent.high_in_world = any ? extent.high_in_world.cwiseMax(p).eval() : p;
    any = true;
  };
  for (const CameraCalibration& camera : calibration.cameras)
    if (camera.world_from_camera.translation.allFinite()) include(camera.world_from_camera.translation);
  if (any) extent.middle_in_world = 0.5 * (extent.low_in_world + extent.high_in_world);

  std::vector<double> values;
  Eigen::Vector3d low, high, middle;
  for (int axis = 0; axis < 3; ++axis) {
    values.clear();
    for (const Eigen::Vector3d& p : samples_in_world)
      if (p.allFinite()) values.push_back(p[axis]);
    if (values.empty()) break;
    std::sort(values.begin(), values.end());
    const auto at = [&](double share) {
      return values[static_cast<std::size_t>(share * static_cast<double>(values.size() - 1))];
    };
    low[axis] = at(0.005);
    high[axis] = at(0.995);
    middle[axis] = at(0.5);
  }
  if (!values.empty()) {
    include(low);
    include(high);
    extent.middle_in_world = middle;
  }
  const double size = (extent.high_in_world - extent.low_in_world).maxCoeff();
  if (extent.low_in_world.z() > 0 && extent.low_in_world.z() < size) extent.low_in_world.z() = 0;
  // Cameras beside each other span no area of their own.
  for (int axis = 0; axis < 3; ++axis) {
    const double lacks =
        std::max(0.25 * size, 0.01) - (extent.high_in_world[axis] - extent.low_in_world[axis]);
    if (lacks <= 0) continue;
    extent.low_in_world[axis] -= lacks / 2;
    extent.high_in_world[axis] += lacks / 2;
  }
  return extent;
}

}  // namespace glint
