// SPDX-License-Identifier: MIT
// A grid of boxes.
#include "host/sim/cells.hpp"

#include <array>

namespace glint::sim {

std::vector<Cell> cells(const Volume& volume, std::uint32_t count) {
  const double width_m = 2.0 * volume.half_width_m, height_m = volume.ceiling_m - volume.floor_m;
  std::array<std::uint32_t, 3> along{1, 1, 1};
  while (along[0] * along[1] * along[2] < count) {  // the longest side of the boxes is cut next
    const std::array<double, 3> side_m{width_m / along[0], width_m / along[1], height_m / along[2]};
    const std::size_t longest =
        side_m[0] >= side_m[1] ? (side_m[0] >= side_m[2] ? 0 : 2) : (side_m[1] >= side_m[2] ? 1 : 2);
    ++along[longest];
  }
  const Eigen::Vector3d side(width_m / along[0], width_m / along[1], height_m / along[2]);
  const Eigen::Vector3d corner(-volume.half_width_m, -volume.half_width_m, volume.floor_m);
  std::vector<Cell> list;
  list.reserve(count);
  for (std::uint32_t i = 0; i < count; ++i) {
    const Eigen::Vector3d place(i % along[0], i / along[0] % along[1], i / (along[0] * along[1]));
    list.push_back({corner + (place + Eigen::Vector3d::Constant(0.5)).cwiseProduct(side), 0.5 * side});
  }
  return list;
}

}  // namespace glint::sim
