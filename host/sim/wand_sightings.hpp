// SPDX-License-Identifier: MIT
// Where the cameras see a waved wand, without rendering: exact images with normal noise.
#pragma once

#include <cstdint>
#include <vector>

#include <Eigen/Core>

#include "host/geometry/camera.hpp"
#include "host/sim/options.hpp"

namespace glint {

struct WandSighting {
  std::uint64_t tick = 0;
  std::uint32_t camera = 0, point = 0;  ///< indices into the rig's cameras and options.wand_m
  Eigen::Vector2d pixel = Eigen::Vector2d::Zero();
};

struct WandSightingOptions {
  std::size_t ticks = 1000;
  double period_s = 0.1;   ///< between ticks
  double sigma_px = 0.05;  ///< standard deviation, per axis
};

/// By tick, camera and point. A camera sees all of the wand's markers or none. Of a wand of two the ends come
/// in random order, as a detector would give them.
std::vector<WandSighting> wand_sightings(const Calibration& rig, const SimOptions& sim,
                                         const WandSightingOptions& options);

}  // namespace glint
