// SPDX-License-Identifier: MIT
#include "host/calibrate/bundle.hpp"

#include <algorithm>
#include <memory>

#include <ceres/ceres.h>

#include "host/base/error.hpp"
#include "host/calibrate/reprojection_cost.hpp"

namespace glint {
namespace {

constexpr double kRobustFrom = 3.0;  // standard deviations

/// The parameters as Ceres moves them.
struct CameraBlocks {
  Eigen::Quaterniond rotation;
  Eigen::Vector3d translation;
  Intrinsics intrinsics;
};

class Adjustment {
 public:
  Adjustment(Bundle& bundle, const BundleOptions& options) : bundle_(bundle), options_(options) {
    take_parameters();
    add_sightings();
    if (bundle_.target.kind == TargetKind::Wand) add_lengths();
    add_cameras();
  }

  BundleSummary run() {
    ceres::Solver::Options solver;
    solver.max_num_iterations = options_.max_steps;
    solver.num_threads = 1;  // several add up in another order each time
    solver.logging_type = ceres::SILENT;
    solver.function_tolerance = 1e-9;
    solver.parameter_tolerance = 1e-10;
    if (options_.schur) {
      // Few cameras and many ticks: what is left after the elimination is small and full.
      solver.linear_solver_type = ceres::DENSE_SCHUR;
      auto order = std::make_shared<ceres::ParameterBlockOrdering>();
      for (std::size_t t = 0; t < bundle_.ticks.size(); ++t)
        if (problem_.HasParameterBlock(target(t))) order->AddElementToGroup(target(t), 0);
      for (CameraBlocks& camera : cameras_) {
        if (!problem_.HasParameterBlock(camera.translation.data())) continue;
        order->AddElementToGroup(camera.rotation.coeffs().data(), 1);
        order->AddElementToGroup(camera.translation.data(), 1);
        order->AddElementToGroup(camera.intrinsics.data(), 1);
      }
      solver.linear_solver_ordering = std::move(order);
    }
    ceres::Solver::Summary said;
    ceres::Solve(solver, &problem_, &said);
    if (said.termination_type == ceres::FAILURE) throw Error("the bundle adjustment failed: " + said.message);
    give_parameters();
    return {said.termination_type == ceres::CONVERGENCE, static_cast<int>(said.iterations.size()),
            said.total_time_in_seconds, said.message};
  }

 private:
  double* target(std::size_t tick) noexcept {
    return targets_.data() + tick * (board() ? 7 : 3 * bundle_.target.points_in_target.size());
  }
  bool board() const noexcept { return bundle_.target.kind == TargetKind::Board; }

  void take_parameters() {
    for (const BundleCamera& camera : bundle_.cameras)
      cameras_.push_back({camera.camera_from_world.rotation.normalized(),
                          camera.camera_from_world.translation, camera.intrinsics});
    for (const BundleTick& tick : bundle_.ticks) {
      if (board()) {
        const PoseBlock block = pose_block(tick.world_from_target);
        targets_.insert(targets_.end(), block.begin(), block.end());
      } else {
        targets_.insert(targets_.end(), tick.points_in_world.data(),
                        tick.points_in_world.data() + tick.points_in_world.size());
      }
    }
  }

  void give_parameters() {
    for (std::size_t c = 0; c < cameras_.size(); ++c) {
      bundle_.cameras[c].camera_from_world = {cameras_[c].rotation.normalized(), cameras_[c].translation};
      bundle_.cameras[c].intrinsics = cameras_[c].intrinsics;
    }
    for (std::size_t t = 0; t < bundle_.ticks.size(); ++t) {
      if (board()) {
        bundle_.ticks[t].world_from_target = pose_of(target(t));
      } else {
        bundle_.ticks[t].points_in_world = Eigen::Map<const Eigen::Matrix3Xd>(
            target(t), 3, static_cast<Eigen::Index>(bundle_.target.points_in_target.size()));
      }
    }
  }

  ceres::CostFunction* cost_of(const BundleSighting& s) const {
    const SightingTerms terms{s.pixel, options_.sigma_px, bundle_.target.marker_radius_m};
    const Eigen::Vector3d& point = bundle_.target.points_in_target[s.point];
    if (board()) return new BoardCost(terms, point);
    const int number = static_cast<int>(s.point);
    switch (bundle_.target.points_in_target.size()) {
      case 1:
        return new PointCost<3>(terms, number);
      case 2:
        return new PointCost<6>(terms, number);
      default:
        return new PointCost<9>(terms, number);
    }
  }

  void add_sightings() {
    for (const BundleSighting& s : bundle_.sightings) {
      CameraBlocks& camera = cameras_[s.camera];
      problem_.AddResidualBlock(cost_of(s), options_.robust ? &robust_loss_ : nullptr,
                                camera.rotation.coeffs().data(), camera.translation.data(),
                                camera.intrinsics.data(), target(s.tick));
    }
    if (!board()) return;
    for (std::size_t t = 0; t < bundle_.ticks.size(); ++t)
      if (problem_.HasParameterBlock(target(t))) problem_.SetManifold(target(t), &board_manifold_);
  }

  void add_lengths() {
    const std::vector<Eigen::Vector3d>& points = bundle_.target.points_in_target;
    const int count = static_cast<int>(points.size());
    for (std::size_t t = 0; t < bundle_.ticks.size(); ++t) {
      for (int a = 0; a < count; ++a) {
        for (int b = a + 1; b < count; ++b) {
          const double length_m =
              (points[static_cast<std::size_t>(b)] - points[static_cast<std::size_t>(a)]).norm();
          ceres::CostFunction* cost = nullptr;
          if (count == 2) cost = new LengthCost<6>(a, b, length_m, options_.length_sd_m);
          if (count == 3) cost = new LengthCost<9>(a, b, length_m, options_.length_sd_m);
          problem_.AddResidualBlock(cost, nullptr, target(t));
        }
      }
    }
  }

  void add_cameras() {
    const bool floating = std::none_of(bundle_.cameras.begin(), bundle_.cameras.end(),
                                       [](const BundleCamera& camera) { return camera.pose_fixed; });
    for (std::size_t c = 0; c < cameras_.size(); ++c) {
      CameraBlocks& camera = cameras_[c];
      if (!problem_.HasParameterBlock(camera.translation.data())) continue;
      problem_.SetManifold(camera.rotation.coeffs().data(), &rotation_manifold_);
      if (bundle_.cameras[c].pose_fixed || (floating && c == 0)) {
        problem_.SetParameterBlockConstant(camera.rotation.coeffs().data());
        problem_.SetParameterBlockConstant(camera.translation.data());
      } else if (floating && c == 1 && !options_.scale_known) {
        problem_.SetManifold(camera.translation.data(), &direction_manifold_);
      }
      add_intrinsics(bundle_.cameras[c], camera);
    }
  }

  void add_intrinsics(const BundleCamera& known, CameraBlocks& camera) {
    std::vector<int> constant;
    for (int k = 0; k < 9; ++k)
      if (!options_.refine_intrinsics || !(known.intrinsics_sd[static_cast<std::size_t>(k)] > 0.0))
        constant.push_back(k);
    if (constant.size() == 9) {
      problem_.SetParameterBlockConstant(camera.intrinsics.data());
      return;
    }
    if (!constant.empty()) {
      subset_manifolds_.push_back(std::make_unique<ceres::SubsetManifold>(9, constant));
      problem_.SetManifold(camera.intrinsics.data(), subset_manifolds_.back().get());
    }
    problem_.AddResidualBlock(new IntrinsicsPrior(known.intrinsics, known.intrinsics_sd), nullptr,
                              camera.intrinsics.data());
  }

  static ceres::Problem::Options shared_parts() {
    ceres::Problem::Options options;
    options.loss_function_ownership = ceres::DO_NOT_TAKE_OWNERSHIP;
    options.manifold_ownership = ceres::DO_NOT_TAKE_OWNERSHIP;
    return options;
  }

  Bundle& bundle_;
  const BundleOptions& options_;
  std::vector<CameraBlocks> cameras_;
  // One after the other, since Ceres orders blocks by their addresses: so the order is the same in every run.
  std::vector<double> targets_;
  ceres::CauchyLoss robust_loss_{kRobustFrom};
  ceres::EigenQuaternionManifold rotation_manifold_;
  ceres::SphereManifold<3> direction_manifold_;
  PoseManifold board_manifold_;
  std::vector<std::unique_ptr<ceres::SubsetManifold>> subset_manifolds_;
  ceres::Problem problem_{shared_parts()};
};

}  // namespace

BundleSummary adjust(Bundle& bundle, const BundleOptions& options) {
  return Adjustment(bundle, options).run();
}

}  // namespace glint
