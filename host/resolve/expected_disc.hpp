// SPDX-License-Identifier: MIT
// From a marker in space to the disc that it should show, and from a disc in the image back to a ray.
#pragma once

#include <optional>

#include <Eigen/Core>

#include "host/geometry/camera.hpp"
#include "host/resolve/disc_fit.hpp"

namespace glint {

/// The outline of a ball through perspective and lens: its centroid and shape in the raw image, to second
/// order in its size, and its path over the exposure. Brightness stays unknown. Nothing if the ball is not
/// wholly in front of the camera or where the lens model folds over; it may lie outside the image.
std::optional<ExpectedDisc> expected_disc(const Camera& camera, const Eigen::Vector3d& position_in_world,
                                          const Eigen::Vector3d& velocity_in_world, double marker_radius_m,
                                          double exposure_s) noexcept;

/// A disc's centre as triangulation wants it.
struct OutlineCentre {
  Eigen::Vector2d normalized = Eigen::Vector2d::Zero();          ///< of the outline in the z = 1 plane
  Eigen::Matrix2d covariance_px2 = Eigen::Matrix2d::Identity();  ///< in undistorted pixels
};

/// The centroid of an outline in the raw image to the centroid of the same outline in the z = 1 plane, which
/// is what remove_sphere_bias() expects. Unlike BlobRecord::x_undist, which is the mean of the undistorted
/// pixels, it counts the area that a raw pixel covers there: for a ball that looks 8 px large in radius the
/// two differ by some hundredths of a pixel. Nothing where the lens model folds over.
std::optional<OutlineCentre> outline_centre(const Camera& camera, const Eigen::Vector2d& centroid_px,
                                            const Eigen::Matrix2d& shape_px2,
                                            const Eigen::Matrix2d& covariance_px2) noexcept;

}  // namespace glint
