// SPDX-License-Identifier: MIT
// A first guess of a camera's focal lengths from views of a plane.
#pragma once

#include <cstdint>
#include <span>

#include <Eigen/Core>

#include "host/geometry/camera.hpp"

namespace glint {

/// Focal lengths in closed form from homographies (plane in metres to pixels), the principal point taken for
/// the middle of the image and the lens for a perfect one (Zhang, A Flexible New Technique for Camera
/// Calibration, PAMI 22(11), 2000, section 3.1 with what is left unknown). Where the views do not tell,
/// because the plane was always parallel to the image, a lens of 53 degrees across. Name and pose stay empty.
CameraCalibration zhang_start(std::span<const Eigen::Matrix3d> image_from_plane, std::uint32_t width_px,
                              std::uint32_t height_px);

/// Unit normal of the plane in camera coordinates, on the side that the camera sees.
Eigen::Vector3d plane_normal(const CameraCalibration& camera, const Eigen::Matrix3d& image_from_plane);

}  // namespace glint
