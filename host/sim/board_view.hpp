// SPDX-License-Identifier: MIT
// The picture of a printed board, as a camera of the simulated rig takes it.
#pragma once

#include <cstdint>
#include <vector>

#include <Eigen/Core>
#include <Eigen/Geometry>

#include "host/geometry/camera.hpp"
#include "host/sim/options.hpp"

namespace glint::sim {

/// What is printed, in the board's plane z = 0, metres; x right and y down on the page.
struct PrintedBoard {
  Eigen::AlignedBox2d sheet;               ///< white
  std::vector<Eigen::AlignedBox2d> black;  ///< within it; they may touch but not overlap
};

/// Grey levels above the sensor's black level.
struct BoardLight {
  double white_grey = 170.0, black_grey = 14.0;  ///< toner reflects a twelfth of what paper does
  double room_grey = 30.0;                       ///< behind the board
};

/// The picture without noise: every edge goes exactly through lens, blur and pixel aperture
/// (Patch::add_filled). Row by row, without gaps. The whole sheet must lie where the lens model holds
/// (board_in_view()).
std::vector<float> board_image(const CameraCalibration& camera, const Pose& camera_from_board,
                               const PrintedBoard& board, const SimSensor& sensor,
                               const BoardLight& light = {});

/// The same with the sensor's noise, 8 bits; `pixels` has height rows of `stride_bytes`.
void board_picture(const CameraCalibration& camera, const Pose& camera_from_board, const PrintedBoard& board,
                   const SimSensor& sensor, std::uint64_t seed, std::uint8_t* pixels,
                   std::uint32_t stride_bytes, const BoardLight& light = {});

/// Whether all of `area` lies in front of the camera, facing it, and `margin_px` inside the image.
bool board_in_view(const CameraCalibration& camera, const Pose& camera_from_board,
                   const Eigen::AlignedBox2d& area, double margin_px);

}  // namespace glint::sim
