// SPDX-License-Identifier: MIT
// Puts the world where people want it: origin and axes on the floor, and its size right.
#pragma once

#include <span>
#include <string>
#include <vector>

#include <Eigen/Core>

#include "host/calibrate/quality.hpp"
#include "host/geometry/camera.hpp"
#include "host/geometry/pose.hpp"

namespace glint {

/// Three or more markers on a right angle: one at its corner, the others on its two arms. Seen from above,
/// the y arm is a quarter turn to the left of the x arm.
struct LFrame {
  std::vector<double> x_arm_m, y_arm_m;  ///< from the corner's marker to each of the others; all different
  double marker_height_m = 0.0;          ///< of the markers' centres above the floor
};

struct Ground {
  Pose new_world_from_world;
  double fit_rms_m = 0.0;  ///< how far the markers are from where they should be; 0: nothing to compare with
  std::vector<std::string> notes;  ///< "cam3 stands 0.20 m below the floor", where that may be meant
};

/// Finds which point is the corner and which lie on the arms from the distances alone; of up to 12 points,
/// others may be there too. Throws Error if no choice of points fits, if several do, or if the cameras would
/// look from below.
Ground ground_from_l_frame(std::span<const Eigen::Vector3d> points_in_world, const LFrame& frame,
                           const Calibration& calibration);

/// Origin, a point on the x axis and a third on the side of positive y, in this order. Throws Error if they
/// are nearly on one line, or if the cameras would look from below.
Ground ground_from_markers(const Eigen::Vector3d& origin, const Eigen::Vector3d& on_x,
                           const Eigen::Vector3d& in_xy, double marker_height_m,
                           const Calibration& calibration);

/// Origin and x axis are the board's; z is the side of it that most cameras are on. `thickness_m` is that of
/// the board.
Ground ground_from_board(const Pose& world_from_board, double thickness_m, const Calibration& calibration);

/// For want of anything better: z along the mean of the cameras' upward axes, x to the right of the first
/// camera, the origin in the middle of the points and as low as they reach (of none, in the middle of the
/// cameras). Good enough for pictures; the floor is a guess.
Pose provisional_world_from_world(const Calibration& calibration,
                                  std::span<const Eigen::Vector3d> points_in_world);

/// By what the world must be enlarged for two points to lie that far apart. Throws Error unless both
/// distances are more than a millimetre.
double scale_for_distance(const Eigen::Vector3d& a_in_world, const Eigen::Vector3d& b_in_world,
                          double true_m);

/// Enlarges the world, then turns and shifts it: X_new = new_world_from_world * (scale * X). Pictures stay
/// the same.
void transform(Calibration& calibration, const Pose& new_world_from_world, double scale = 1.0);
/// The same for what is known of the calibration's uncertainty; call it with the calibration as it is after.
void transform(CalibrationUncertainty& uncertainty, const Calibration& transformed,
               const Pose& new_world_from_world, double scale = 1.0);

}  // namespace glint
