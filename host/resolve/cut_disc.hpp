// SPDX-License-Identifier: MIT
// What a detector's limit leaves of a blurred disc.
#pragma once

#include <array>
#include <cstddef>
#include <vector>

#include "host/resolve/disc_profile.hpp"

namespace glint {

/// Of a disc of brightness 1 above a dark of 0, only what lies above a limit and counted from there.
struct CutDisc {
  double area_px2 = 0.0;
  double light_px2 = 0.0;          ///< sum over the pixels of their excess over the limit
  double second_moment_px2 = 0.0;  ///< of that light, along each axis
};

/// Tabulated once over radius and limit, since it is asked of every blob that a track expects.
class CutDiscs {
 public:
  explicit CutDiscs(const DiscProfiles& profiles);
  /// `limit`: in parts of the disc's brightness. All 0 where nothing of it reaches the limit.
  CutDisc of(double radius_px, double limit) const noexcept;

 private:
  // As lengths, which are nearly linear in the radius: of circles with that area, of that light, and of that
  // second moment.
  struct Node {
    float area, light, moment;
  };
  static constexpr std::size_t kLimits = 48;
  double sigma_px_;
  std::vector<std::array<Node, kLimits>> rows_;  // by radius; within, by the root of the limit
};

}  // namespace glint
