// SPDX-License-Identifier: MIT
// By the singular values of the covariance between both sets of points.
#include "host/body/point_pose.hpp"

#include <cmath>

#include <Eigen/LU>
#include <Eigen/SVD>

namespace glint {
namespace {

constexpr double kLeastSpread = 1e-4;  // second singular value by the first: below, the points lie on a line

std::optional<Eigen::Matrix3d> axes_of(const std::array<Eigen::Vector3d, 3>& p) noexcept {
  const Eigen::Vector3d x = p[1] - p[0], across = x.cross(p[2] - p[0]);
  if (!(across.norm() > 1e-3 * x.squaredNorm())) return std::nullopt;
  Eigen::Matrix3d axes;
  axes.col(0) = x.normalized();
  axes.col(2) = across.normalized();
  axes.col(1) = axes.col(2).cross(axes.col(0));
  return axes;
}

}  // namespace

std::optional<Pose> pose_from_points(std::span<const Eigen::Vector3d> points_in_b,
                                     std::span<const Eigen::Vector3d> points_in_a,
                                     std::span<const double> weights) noexcept {
  const std::size_t n = points_in_b.size();
  if (n < 3 || points_in_a.size() != n) return std::nullopt;
  const auto weight = [&](std::size_t k) { return weights.empty() ? 1.0 : weights[k]; };
  double sum = 0.0;
  Eigen::Vector3d a = Eigen::Vector3d::Zero(), b = Eigen::Vector3d::Zero();
  for (std::size_t k = 0; k < n; ++k) {
    sum += weight(k);
    a += weight(k) * points_in_a[k];
    b += weight(k) * points_in_b[k];
  }
  if (!(sum > 0.0)) return std::nullopt;
  a /= sum;
  b /= sum;
  Eigen::Matrix3d product = Eigen::Matrix3d::Zero();
  for (std::size_t k = 0; k < n; ++k)
    product.noalias() += weight(k) * (points_in_a[k] - a) * (points_in_b[k] - b).transpose();
  if (!product.allFinite()) return std::nullopt;
  const Eigen::JacobiSVD<Eigen::Matrix3d> svd(product, Eigen::ComputeFullU | Eigen::ComputeFullV);
  if (!(svd.singularValues()[1] > kLeastSpread * svd.singularValues()[0])) return std::nullopt;
  Eigen::Matrix3d u = svd.matrixU();
  if (u.determinant() * svd.matrixV().determinant() < 0.0) u.col(2) = -u.col(2);
  const Eigen::Matrix3d rotation = u * svd.matrixV().transpose();
  Pose pose;
  pose.rotation = Eigen::Quaterniond(rotation).normalized();
  pose.translation = a - pose.rotation * b;
  return pose;
}

double rms_distance(const Pose& a_from_b, std::span<const Eigen::Vector3d> points_in_b,
                    std::span<const Eigen::Vector3d> points_in_a) noexcept {
  double squares = 0.0;
  for (std::size_t k = 0; k < points_in_b.size(); ++k)
    squares += (points_in_a[k] - a_from_b * points_in_b[k]).squaredNorm();
  return points_in_b.empty() ? 0.0 : std::sqrt(squares / static_cast<double>(points_in_b.size()));
}

std::optional<Pose> pose_from_triple(const std::array<Eigen::Vector3d, 3>& in_b,
                                     const std::array<Eigen::Vector3d, 3>& in_a) noexcept {
  const auto a = axes_of(in_a), b = axes_of(in_b);
  if (!a || !b) return std::nullopt;
  Pose pose;
  pose.rotation = Eigen::Quaterniond(Eigen::Matrix3d(*a * b->transpose())).normalized();
  pose.translation = in_a[0] - pose.rotation * in_b[0];
  return pose;
}

}  // namespace glint
