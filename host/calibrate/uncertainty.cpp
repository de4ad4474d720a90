// SPDX-License-Identifier: MIT
#include "host/calibrate/uncertainty.hpp"

#include <algorithm>

#include <Eigen/Dense>

#include "host/calibrate/reprojection_cost.hpp"
#include "host/geometry/rotation.hpp"

namespace glint {
namespace {

// How much the cameras' orientations count beside their positions in the alignment, relative to the size of
// the rig: just enough to fix what positions on a line leave open.
constexpr double kOrientationWeight = 0.01;

class Uncertainty {
 public:
  Uncertainty(const Bundle& bundle, const BundleOptions& options, double sigma_px)
      : bundle_(bundle),
        options_(options),
        sigma_px_(sigma_px),
        per_camera_(options.refine_intrinsics ? 15 : 6),
        size_(per_camera_ * static_cast<Eigen::Index>(bundle.cameras.size())),
        information_(Eigen::MatrixXd::Zero(size_, size_)) {}

  CalibrationUncertainty run() {
    add_priors();
    std::vector<std::vector<const BundleSighting*>> by_tick(bundle_.ticks.size());
    for (const BundleSighting& s : bundle_.sightings) by_tick[s.tick].push_back(&s);
    for (std::size_t t = 0; t < by_tick.size(); ++t)
      if (!by_tick[t].empty()) add_tick(bundle_.ticks[t], by_tick[t]);
    hold_constants();
    CalibrationUncertainty result;
    result.intrinsics = options_.refine_intrinsics;
    result.sigma_px = sigma_px_;
    result.covariance = inverse();
    return result;
  }

 private:
  Eigen::Index begin_of(std::uint32_t camera) const {
    return per_camera_ * static_cast<Eigen::Index>(camera);
  }
  Eigen::Index target_size() const {
    return bundle_.target.kind == TargetKind::Board
               ? 6
               : 3 * static_cast<Eigen::Index>(bundle_.target.points_in_target.size());
  }

  void add_priors() {
    if (!options_.refine_intrinsics) return;
    for (std::uint32_t c = 0; c < bundle_.cameras.size(); ++c) {
      for (Eigen::Index k = 0; k < 9; ++k) {
        const double sd = bundle_.cameras[c].intrinsics_sd[static_cast<std::size_t>(k)];
        if (sd > 0.0) information_(begin_of(c) + 6 + k, begin_of(c) + 6 + k) += 1.0 / (sd * sd);
      }
    }
  }

  void add_tick(const BundleTick& tick, const std::vector<const BundleSighting*>& sightings) {
    const Eigen::Index targets = target_size();
    Eigen::MatrixXd target = Eigen::MatrixXd::Zero(targets, targets);
    Eigen::MatrixXd both = Eigen::MatrixXd::Zero(size_, targets);
    std::vector<std::uint32_t> seen_by;
    for (const BundleSighting* s : sightings) {
      const BundleCamera& camera = bundle_.cameras[s->camera];
      const Eigen::Matrix3d rotation = camera.camera_from_world.rotation.toRotationMatrix();
      const Eigen::Vector3d& in_target = bundle_.target.points_in_target[s->point];
      const bool board = bundle_.target.kind == TargetKind::Board;
      const Eigen::Vector3d world = board ? Eigen::Vector3d(tick.world_from_target * in_target)
                                          : Eigen::Vector3d(tick.points_in_world.col(s->point));
      PredictedSighting seen;
      if (!predict_sighting(camera.intrinsics.data(), camera.camera_from_world * world,
                            bundle_.target.marker_radius_m, seen))
        continue;
      Eigen::MatrixXd by_camera(2, per_camera_);
      by_camera.leftCols<3>() = -seen.by_point_in_camera * cross_matrix(rotation * world);
      by_camera.middleCols<3>(3) = seen.by_point_in_camera;
      if (options_.refine_intrinsics) by_camera.rightCols<9>() = seen.by_intrinsics;
      Eigen::MatrixXd by_target = Eigen::MatrixXd::Zero(2, targets);
      const Eigen::Matrix<double, 2, 3> by_world = seen.by_point_in_camera * rotation;
      if (board) {
        by_target.leftCols<3>() = -by_world * cross_matrix(tick.world_from_target.rotation * in_target);
        by_target.rightCols<3>() = by_world;
      } else {
        by_target.middleCols<3>(3 * static_cast<Eigen::Index>(s->point)) = by_world;
      }
      const double weight = 1.0 / (sigma_px_ * sigma_px_);
      const Eigen::Index at = begin_of(s->camera);
      information_.block(at, at, per_camera_, per_camera_) += weight * by_camera.transpose() * by_camera;
      both.middleRows(at, per_camera_) += weight * by_camera.transpose() * by_target;
      target += weight * by_target.transpose() * by_target;
      if (std::find(seen_by.begin(), seen_by.end(), s->camera) == seen_by.end()) seen_by.push_back(s->camera);
    }
    if (bundle_.target.kind == TargetKind::Wand) add_lengths(tick, target);
    const Eigen::LDLT<Eigen::MatrixXd> factor(target);
    for (const std::uint32_t a : seen_by) {
      const Eigen::MatrixXd solved = factor.solve(both.middleRows(begin_of(a), per_camera_).transpose());
      for (const std::uint32_t b : seen_by) {
        information_.block(begin_of(b), begin_of(a), per_camera_, per_camera_) -=
            both.middleRows(begin_of(b), per_camera_) * solved;
      }
    }
  }

  void add_lengths(const BundleTick& tick, Eigen::MatrixXd& target) const {
    const double weight = 1.0 / (options_.length_sd_m * options_.length_sd_m);
    for (Eigen::Index a = 0; a < tick.points_in_world.cols(); ++a) {
      for (Eigen::Index b = a + 1; b < tick.points_in_world.cols(); ++b) {
        Eigen::VectorXd row = Eigen::VectorXd::Zero(target.rows());
        const Eigen::Vector3d along =
            (tick.points_in_world.col(b) - tick.points_in_world.col(a)).normalized();
        row.segment<3>(3 * b) = along;
        row.segment<3>(3 * a) = -along;
        target += weight * row * row.transpose();
      }
    }
  }

  /// What the adjustment did not move is known exactly here: a huge information, a vanishing covariance.
  void hold_constants() {
    constexpr double kExactly = 1e18;
    for (std::uint32_t c = 0; c < bundle_.cameras.size(); ++c) {
      const BundleCamera& camera = bundle_.cameras[c];
      if (camera.pose_fixed) information_.diagonal().segment(begin_of(c), 6).array() += kExactly;
      if (!options_.refine_intrinsics) continue;
      for (Eigen::Index k = 0; k < 9; ++k)
        if (!(camera.intrinsics_sd[static_cast<std::size_t>(k)] > 0.0))
          information_(begin_of(c) + 6 + k, begin_of(c) + 6 + k) += kExactly;
    }
  }

  /// What moves when the world is turned (3), shifted (3) and scaled (1), and how the cameras' positions and
  /// (weighted) orientations feel a change of their parameters.
  Eigen::MatrixXd alignment() const {
    const bool scale = !options_.scale_known;
    const auto count = static_cast<Eigen::Index>(bundle_.cameras.size());
    Eigen::MatrixXd motion = Eigen::MatrixXd::Zero(size_, scale ? 7 : 6);
    Eigen::MatrixXd felt = Eigen::MatrixXd::Zero(6 * count, size_);
    double extent = 0.0;
    for (const BundleCamera& camera : bundle_.cameras)
      extent = std::max(extent, camera.camera_from_world.translation.norm());
    for (std::uint32_t c = 0; c < bundle_.cameras.size(); ++c) {
      const Eigen::Matrix3d rotation = bundle_.cameras[c].camera_from_world.rotation.toRotationMatrix();
      const Eigen::Vector3d& t = bundle_.cameras[c].camera_from_world.translation;
      const Eigen::Index at = begin_of(c), row = 6 * static_cast<Eigen::Index>(c);
      motion.block<3, 3>(at, 0) = rotation;      // R exp(w) = exp(R w) R
      motion.block<3, 3>(at + 3, 3) = rotation;  // R (x + v) + t
      if (scale) motion.block<3, 1>(at + 3, 6) = t;
      // The position is -R^T t: under exp(r) R and t + d it moves by R^T (r x t) - R^T d.
      felt.block<3, 3>(row, at) = -rotation.transpose() * cross_matrix(t);
      felt.block<3, 3>(row, at + 3) = -rotation.transpose();
      felt.block<3, 3>(row + 3, at) = kOrientationWeight * extent * Eigen::Matrix3d::Identity();
    }
    return (felt * motion).transpose() * felt;
  }

  Eigen::MatrixXd inverse() const {
    // Scaled to a unit diagonal first: metres, radians and pixels differ by many orders of magnitude.
    const Eigen::VectorXd scale = information_.diagonal().cwiseMax(1e-300).cwiseSqrt().cwiseInverse();
    const Eigen::MatrixXd scaled = scale.asDiagonal() * information_ * scale.asDiagonal();
    const bool floating = std::none_of(bundle_.cameras.begin(), bundle_.cameras.end(),
                                       [](const BundleCamera& camera) { return camera.pose_fixed; });
    Eigen::MatrixXd covariance;
    if (!floating) {
      covariance = scaled.ldlt().solve(Eigen::MatrixXd::Identity(size_, size_));
    } else {
      Eigen::MatrixXd constraint = alignment() * scale.asDiagonal();
      for (Eigen::Index row = 0; row < constraint.rows(); ++row) constraint.row(row).normalize();
      const Eigen::Index all = size_ + constraint.rows();
      Eigen::MatrixXd bordered = Eigen::MatrixXd::Zero(all, all);
      bordered.topLeftCorner(size_, size_) = scaled;
      bordered.topRightCorner(size_, constraint.rows()) = constraint.transpose();
      bordered.bottomLeftCorner(constraint.rows(), size_) = constraint;
      covariance = bordered.fullPivLu().inverse().topLeftCorner(size_, size_);
    }
    covariance = scale.asDiagonal() * covariance * scale.asDiagonal();
    return 0.5 * (covariance + covariance.transpose());
  }

  const Bundle& bundle_;
  const BundleOptions& options_;
  double sigma_px_;
  Eigen::Index per_camera_, size_;
  Eigen::MatrixXd information_;
};

}  // namespace

CalibrationUncertainty uncertainty_of(const Bundle& bundle, const BundleOptions& options, double sigma_px) {
  return Uncertainty(bundle, options, sigma_px).run();
}

}  // namespace glint
