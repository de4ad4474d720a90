// SPDX-License-Identifier: MIT
// Start from a homography (plane) or a direct linear transform (anything else), then least squares in the
// image.
#include "host/calibrate/pnp.hpp"

#include <algorithm>
#include <cmath>

#include <ceres/ceres.h>
#include <Eigen/Geometry>
#include <Eigen/LU>
#include <Eigen/SVD>

#include "host/base/check.hpp"
#include "host/calibrate/homography.hpp"
#include "host/calibrate/reprojection_cost.hpp"

namespace glint {
namespace {

struct Points {
  std::vector<Eigen::Vector3d> in_target;
  std::vector<Eigen::Vector2d> pixel, normalized;  // z = 1 plane
};

/// Least squares in the image from that start; nothing if it starts or ends behind the camera.
std::optional<TargetPose> refine(Intrinsics intrinsics, const Points& points, const Pose& start) {
  PoseBlock pose = pose_block(start);
  ceres::Problem problem;
  for (std::size_t i = 0; i < points.pixel.size(); ++i) {
    problem.AddResidualBlock(new ViewCost(points.pixel[i], points.in_target[i]), nullptr, pose.data(),
                             intrinsics.data());
  }
  problem.SetManifold(pose.data(), new PoseManifold);
  problem.SetParameterBlockConstant(intrinsics.data());
  ceres::Solver::Options options;
  options.linear_solver_type = ceres::DENSE_QR;
  options.max_num_iterations = 50;
  options.function_tolerance = 1e-12;
  options.logging_type = ceres::SILENT;
  ceres::Solver::Summary summary;
  ceres::Solve(options, &problem, &summary);
  if (!summary.IsSolutionUsable()) return std::nullopt;
  // Ceres counts half of the squares.
  return TargetPose{pose_of(pose.data()),
                    std::sqrt(2.0 * summary.final_cost / static_cast<double>(points.pixel.size()))};
}

Eigen::Matrix3d nearest_rotation(const Eigen::Matrix3d& m) {
  const Eigen::JacobiSVD<Eigen::Matrix3d> svd(m, Eigen::ComputeFullU | Eigen::ComputeFullV);
  Eigen::Vector3d sign(1.0, 1.0,
                       (svd.matrixU() * svd.matrixV().transpose()).determinant() < 0.0 ? -1.0 : 1.0);
  return svd.matrixU() * sign.asDiagonal() * svd.matrixV().transpose();
}

/// Both starts for points of a plane: `axes` has its two directions and its normal, `middle` lies in it. Only
/// the homography's value and slope at the middle are used, which noise hardly touches however small the
/// plane is (Collins and Bartoli, Infinitesimal Plane-Based Pose Estimation, IJCV 109, 2014).
std::vector<Pose> plane_starts(const Points& points, const Eigen::Matrix3d& axes,
                               const Eigen::Vector3d& middle) {
  std::vector<Eigen::Vector2d> in_plane;
  for (const Eigen::Vector3d& p : points.in_target)
    in_plane.push_back((axes.transpose() * (p - middle)).head<2>());
  const auto h = find_homography(in_plane, points.normalized);
  if (!h || !((*h)(2, 2) > 0.0)) return {};
  const Eigen::Vector2d at = h->col(2).head<2>() / (*h)(2, 2);
  const Eigen::Matrix2d slope = (h->topLeftCorner<2, 2>() - at * h->row(2).head<2>()) / (*h)(2, 2);
  const Eigen::Matrix3d sight =
      Eigen::Quaterniond::FromTwoVectors(Eigen::Vector3d::UnitZ(), at.homogeneous()).toRotationMatrix();
  // slope = facing * upper / depth, upper the first two rows and columns of the rotation seen along the
  // sight.
  const Eigen::Matrix2d facing = sight.topLeftCorner<2, 2>() - at * sight.row(2).head<2>();
  Eigen::Matrix2d upper = facing.inverse() * slope;
  const double per_depth = upper.jacobiSvd().singularValues()[0];
  if (!(per_depth > 0.0)) return {};
  upper /= per_depth;
  // The third row makes the columns unit vectors at right angles; its sign is what the slope cannot tell.
  const Eigen::Matrix2d rest = Eigen::Matrix2d::Identity() - upper.transpose() * upper;
  Eigen::Vector2d third(std::sqrt(std::max(0.0, rest(0, 0))), std::sqrt(std::max(0.0, rest(1, 1))));
  if (rest(0, 1) < 0.0) third[1] = -third[1];
  const Pose plane_from_target{Eigen::Quaterniond(Eigen::Matrix3d(axes.transpose())),
                               -(axes.transpose() * middle)};
  std::vector<Pose> both;
  for (const double sign : {1.0, -1.0}) {
    Eigen::Matrix3d along_sight;
    along_sight.topLeftCorner<2, 2>() = upper;
    along_sight.row(2).head<2>() = sign * third;
    along_sight.col(2) = along_sight.col(0).cross(along_sight.col(1));
    const Pose camera_from_plane{Eigen::Quaterniond(nearest_rotation(sight * along_sight)),
                                 at.homogeneous() / per_depth};
    both.push_back(camera_from_plane * plane_from_target);
  }
  return both;
}

/// Start for six or more points that lie in no plane.
std::vector<Pose> space_starts(const Points& points, const Eigen::Vector3d& middle, double spread) {
  if (points.in_target.size() < 6) return {};
  Eigen::Matrix<double, 12, 12> normal = Eigen::Matrix<double, 12, 12>::Zero();
  for (std::size_t i = 0; i < points.in_target.size(); ++i) {
    const Eigen::Vector4d p = ((points.in_target[i] - middle) / spread).homogeneous();
    const Eigen::Vector2d& m = points.normalized[i];
    Eigen::Matrix<double, 2, 12> rows;
    rows << p.transpose(), Eigen::RowVector4d::Zero(), -m.x() * p.transpose(),  //
        Eigen::RowVector4d::Zero(), p.transpose(), -m.y() * p.transpose();
    normal += rows.transpose() * rows;
  }
  const Eigen::JacobiSVD<Eigen::Matrix<double, 12, 12>> svd(normal, Eigen::ComputeFullV);
  const Eigen::Matrix<double, 12, 1> v = svd.matrixV().col(11);
  Eigen::Matrix<double, 3, 4> p;
  p << v.segment<4>(0).transpose(), v.segment<4>(4).transpose(), v.segment<4>(8).transpose();
  if (p(2, 3) < 0.0) p = -p;
  const double scale = p.leftCols<3>().jacobiSvd().singularValues().mean();
  if (!(scale > 0.0)) return {};
  const Eigen::Matrix3d rotation = nearest_rotation(p.leftCols<3>() / scale);
  return {Pose{Eigen::Quaterniond(rotation), p.col(3) / scale * spread - rotation * middle}};
}

std::vector<Pose> starts(const Points& points) {
  Eigen::Vector3d middle = Eigen::Vector3d::Zero();
  for (const Eigen::Vector3d& p : points.in_target) middle += p;
  middle /= static_cast<double>(points.in_target.size());
  Eigen::Matrix3d scatter = Eigen::Matrix3d::Zero();
  for (const Eigen::Vector3d& p : points.in_target) scatter += (p - middle) * (p - middle).transpose();
  const Eigen::JacobiSVD<Eigen::Matrix3d> svd(scatter, Eigen::ComputeFullU);
  const Eigen::Vector3d width = svd.singularValues().cwiseSqrt();
  if (!(width[1] > 1e-3 * width[0])) return {};  // on a line
  Eigen::Matrix3d axes = svd.matrixU();
  axes.col(2) = axes.col(0).cross(axes.col(1));
  // What is flat to a hundredth of its width is better started as a plane: the general start is the less
  // stable the flatter the points are.
  if (width[2] < 0.01 * width[1]) return plane_starts(points, axes, middle);
  return space_starts(points, middle, width[0] / std::sqrt(static_cast<double>(points.in_target.size())));
}

}  // namespace

std::vector<TargetPose> target_poses(const CameraCalibration& camera,
                                     std::span<const Eigen::Vector3d> points_in_target,
                                     std::span<const Eigen::Vector2d> pixels) {
  GLINT_CHECK(points_in_target.size() == pixels.size());
  Points points;
  const Camera model(camera);
  for (std::size_t i = 0; i < pixels.size(); ++i) {
    const auto normalized = model.undistort(pixels[i]);
    if (!normalized) continue;
    points.in_target.push_back(points_in_target[i]);
    points.pixel.push_back(pixels[i]);
    points.normalized.push_back(*normalized);
  }
  std::vector<TargetPose> poses;
  if (points.pixel.size() < 4) return poses;
  constexpr double kSame_rad = 0.01;
  for (const Pose& start : starts(points)) {
    const auto refined = refine(intrinsics_of(camera), points, start);
    if (!refined) continue;
    const bool known = std::any_of(poses.begin(), poses.end(), [&](const TargetPose& other) {
      return other.camera_from_target.rotation.angularDistance(refined->camera_from_target.rotation) <
             kSame_rad;
    });
    if (!known) poses.push_back(*refined);
  }
  std::sort(poses.begin(), poses.end(),
            [](const TargetPose& a, const TargetPose& b) { return a.rms_px < b.rms_px; });
  return poses;
}

std::optional<Pose> camera_from_target(const CameraCalibration& camera,
                                       std::span<const Eigen::Vector3d> points_in_target,
                                       std::span<const Eigen::Vector2d> pixels) {
  const std::vector<TargetPose> poses = target_poses(camera, points_in_target, pixels);
  if (poses.empty()) return std::nullopt;
  return poses.front().camera_from_target;
}

}  // namespace glint
