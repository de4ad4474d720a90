// SPDX-License-Identifier: MIT
// A sphere's image is an ellipse whose centre is not the image of the sphere's centre.
#pragma once

#include <Eigen/Core>

namespace glint {

// The rays that touch a sphere (centre c in the camera frame, radius r) fulfil (x.c)^2 = (|c|^2 - r^2) |x|^2.
// With x = (u, v, 1) this is a conic with the matrix c c^T - (|c|^2 - r^2) I; its centre (u, v), where the
// gradient vanishes, is (c_x, c_y) c_z / (c_z^2 - r^2): the image of the centre, moved outwards along the
// line from the principal point by the factor 1 / (1 - (r/c_z)^2). The size of the effect for photogrammetric
// targets is treated in Luhmann, "Eccentricity in images of circular and spherical targets", Photogrammetric
// Record 29 (2014).

/// By what the z = 1 plane image of the sphere's centre must be multiplied to give the centre of the outline.
/// `depth` is the centre's z in the camera frame, in metres like the radius. 1 where the camera is not in
/// front of the sphere.
double sphere_bias_factor(double radius_m, double depth_m) noexcept;

/// z = 1 plane: centre of the outline (what a detector measures) to image of the sphere's centre.
Eigen::Vector2d remove_sphere_bias(const Eigen::Vector2d& outline_centre, double radius_m,
                                   double depth_m) noexcept;

}  // namespace glint
