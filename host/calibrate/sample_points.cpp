// SPDX-License-Identifier: MIT
// Triangulates some of the samples.
#include "host/calibrate/sample_points.hpp"

#include <algorithm>

#include "host/base/check.hpp"
#include "host/geometry/triangulate.hpp"

namespace glint {

std::vector<Eigen::Vector3d> sample_points(const Calibration& calibration, const SampleSet& samples,
                                           std::size_t most) {
  GLINT_CHECK(calibration.cameras.size() == samples.cameras.size());
  const std::vector<Camera> cameras(calibration.cameras.begin(), calibration.cameras.end());
  const std::vector<SampleTick> ticks = ticks_of(samples);
  const std::size_t points_per_tick = std::max<std::size_t>(1, samples.target.points_in_target.size());
  // Of a board with many points, more ticks and fewer points of each.
  const std::size_t point_stride = (points_per_tick + 3) / 4;
  const std::size_t per_tick = (points_per_tick + point_stride - 1) / point_stride;
  const std::size_t tick_stride =
      std::max<std::size_t>(1, ticks.size() * per_tick / std::max<std::size_t>(1, most));
  TriangulateOptions options;
  options.marker_radius_m = samples.target.marker_radius_m;
  std::vector<Eigen::Vector3d> points;
  std::vector<Observation> views;
  for (std::size_t t = 0; t < ticks.size(); t += tick_stride) {
    for (std::uint32_t point = 0; point < points_per_tick;
         point += static_cast<std::uint32_t>(point_stride)) {
      views.clear();
      for (const Sighting& sighting : ticks[t].sightings) {
        if (sighting.point != point) continue;
        const Camera& camera = cameras[sighting.camera];
        if (const auto plane = camera.undistort(sighting.pixel))
          views.push_back({&camera, *plane, Eigen::Matrix2d::Identity()});
      }
      if (const auto found = triangulate(views, options)) points.push_back(found->position_in_world);
    }
  }
  return points;
}

}  // namespace glint
