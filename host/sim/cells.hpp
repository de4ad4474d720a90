// SPDX-License-Identifier: MIT
// Parts of the volume for things that must not meet.
#pragma once

#include <cstdint>
#include <vector>

#include <Eigen/Core>

#include "host/sim/motion.hpp"

namespace glint::sim {

/// A box of the volume.
struct Cell {
  Eigen::Vector3d centre_in_world, half_m;
};

/// `count` equal boxes of the volume, in a grid as coarse as will do.
std::vector<Cell> cells(const Volume& volume, std::uint32_t count);

}  // namespace glint::sim
