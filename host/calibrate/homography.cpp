// SPDX-License-Identifier: MIT
// Direct linear transform of a plane.
#include "host/calibrate/homography.hpp"

#include <cmath>

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <Eigen/SVD>

namespace glint {
namespace {

/// Takes the points' mean to 0 and their mean distance from it to the square root of 2.
Eigen::Matrix3d normaliser(std::span<const Eigen::Vector2d> points) {
  Eigen::Vector2d mean = Eigen::Vector2d::Zero();
  for (const Eigen::Vector2d& p : points) mean += p;
  mean /= static_cast<double>(points.size());
  double distance = 0.0;
  for (const Eigen::Vector2d& p : points) distance += (p - mean).norm();
  const double scale = distance > 0.0 ? std::sqrt(2.0) * static_cast<double>(points.size()) / distance : 1.0;
  Eigen::Matrix3d n;
  n << scale, 0.0, -scale * mean.x(), 0.0, scale, -scale * mean.y(), 0.0, 0.0, 1.0;
  return n;
}

}  // namespace

std::optional<Eigen::Matrix3d> find_homography(std::span<const Eigen::Vector2d> plane,
                                               std::span<const Eigen::Vector2d> image) {
  if (plane.size() != image.size() || plane.size() < 4) return std::nullopt;
  const Eigen::Matrix3d from_plane = normaliser(plane), from_image = normaliser(image);
  Eigen::Matrix<double, 9, 9> normal = Eigen::Matrix<double, 9, 9>::Zero();
  for (std::size_t i = 0; i < plane.size(); ++i) {
    const Eigen::Vector3d p = from_plane * plane[i].homogeneous(), m = from_image * image[i].homogeneous();
    Eigen::Matrix<double, 2, 9> rows;
    rows << p.transpose(), Eigen::RowVector3d::Zero(), -m.x() * p.transpose(),  //
        Eigen::RowVector3d::Zero(), p.transpose(), -m.y() * p.transpose();
    normal += rows.transpose() * rows;
  }
  const Eigen::JacobiSVD<Eigen::Matrix<double, 9, 9>> svd(normal, Eigen::ComputeFullV);
  // The map is known only if it is the only one: a second null vector means points on a line.
  if (!(svd.singularValues()[7] > 1e-10 * svd.singularValues()[0])) return std::nullopt;
  const Eigen::Matrix<double, 9, 1> h = svd.matrixV().col(8);
  Eigen::Matrix3d normalised;
  normalised << h[0], h[1], h[2], h[3], h[4], h[5], h[6], h[7], h[8];
  Eigen::Matrix3d result = from_image.inverse() * normalised * from_plane;
  result /= result.norm();
  double side = 0.0;
  for (const Eigen::Vector2d& p : plane) side += result.row(2) * p.homogeneous();
  if (side < 0.0) result = -result;
  if (!result.allFinite()) return std::nullopt;
  return result;
}

}  // namespace glint
