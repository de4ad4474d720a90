// SPDX-License-Identifier: MIT
// What is shown to the cameras to calibrate them: a marker, a wand or a printed board.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include <Eigen/Core>

namespace glint {

enum class TargetKind : std::uint8_t { Marker, Wand, Board };

/// Points at known places of one rigid thing. Marker: one point at the origin. Wand: two or three points on
/// the x axis, the first at the origin. Board: points of the plane z = 0.
struct Target {
  TargetKind kind = TargetKind::Marker;
  std::vector<Eigen::Vector3d> points_in_target{Eigen::Vector3d::Zero()};
  double marker_radius_m = 0.0;  ///< of a marker's or a wand's spheres; 0: unknown, or no spheres
  std::string
      name;  ///< as the command line names it: "wand:0,0.13,0.39", "charuco:5x4:0.054:0.0405:4X4_1000"
};

Target marker_target(double marker_radius_m);

/// Places of the wand's two or three markers on its axis, from the first (0) outwards. Of three, one spacing
/// must be one and a half times the other at least, for the ends to be told apart. Throws Error saying what
/// is wrong.
Target wand_target(const std::vector<double>& places_m, double marker_radius_m);

}  // namespace glint
