// SPDX-License-Identifier: MIT
#include "host/sim/wand_sightings.hpp"

#include <optional>

#include "host/geometry/sphere_bias.hpp"
#include "host/sim/random.hpp"
#include "host/sim/wand_dance.hpp"

namespace glint {
namespace {

/// Of the centre of a sphere's outline, inside the image.
std::optional<Eigen::Vector2d> seen_at(const Camera& camera, const Eigen::Vector3d& point_in_world,
                                       double radius_m) {
  Eigen::Vector3d in_camera = camera.in_camera(point_in_world);
  in_camera.head<2>() *= sphere_bias_factor(radius_m, in_camera.z());
  const auto pixel = camera.project(camera.calibration().world_from_camera * in_camera);
  constexpr double kMargin_px = 4.0;
  if (!pixel || !camera.inside(*pixel, kMargin_px)) return std::nullopt;
  return pixel;
}

}  // namespace

std::vector<WandSighting> wand_sightings(const Calibration& rig, const SimOptions& sim,
                                         const WandSightingOptions& options) {
  const sim::WandDance dance(sim, sim::Volume{});
  const std::vector<Camera> cameras(rig.cameras.begin(), rig.cameras.end());
  const auto markers = static_cast<std::uint32_t>(sim.wand_m.size());
  sim::Random random(sim::stream_seed(sim.seed, sim::Stream::FrameNoise));
  const sim::NormalTable normal;
  std::vector<WandSighting> sightings;
  for (std::uint64_t tick = 0; tick < options.ticks; ++tick) {
    const double time_s = static_cast<double>(tick) * options.period_s;
    for (std::uint32_t c = 0; c < cameras.size(); ++c) {
      const std::size_t begin = sightings.size();
      for (std::uint32_t point = 0; point < markers; ++point) {
        const auto pixel =
            seen_at(cameras[c], dance.marker(point, time_s).position_in_world, sim.marker_radius_m);
        if (!pixel) break;
        const Eigen::Vector2d error(static_cast<double>(normal.draw(random)),
                                    static_cast<double>(normal.draw(random)));
        sightings.push_back({tick, c, point, *pixel + options.sigma_px * error});
      }
      if (sightings.size() - begin != markers) {
        sightings.resize(begin);
      } else if (markers == 2 && random.uniform() < 0.5) {
        std::swap(sightings[begin].pixel, sightings[begin + 1].pixel);
      }
    }
  }
  return sightings;
}

}  // namespace glint
