// SPDX-License-Identifier: MIT
#include "host/calibrate/relative_pose.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <random>

#include <Eigen/Dense>

#include "host/calibrate/homography.hpp"

namespace glint {
namespace {

constexpr std::size_t kSample = 8;
constexpr std::uint64_t kFewest = 16;
constexpr std::uint32_t kGoodSamples = 30;  // noise decides which of them are near the truth
constexpr std::size_t kTrialTicks = 300;    // spread over all: enough to rank trials by

struct Match {
  Eigen::Vector2d a, b;
  std::uint32_t tick;  // index
};

/// Moves the centroid to the origin and scales the mean distance to sqrt(2), as a 3x3 matrix.
Eigen::Matrix3d normalising(const std::vector<Match>& matches, Eigen::Vector2d Match::*side) {
  Eigen::Vector2d mean = Eigen::Vector2d::Zero();
  for (const Match& m : matches) mean += m.*side;
  mean /= static_cast<double>(matches.size());
  double distance = 0.0;
  for (const Match& m : matches) distance += (m.*side - mean).norm();
  const double scale = std::sqrt(2.0) * static_cast<double>(matches.size()) / std::max(distance, 1e-12);
  Eigen::Matrix3d t;
  t << scale, 0.0, -scale * mean.x(), 0.0, scale, -scale * mean.y(), 0.0, 0.0, 1.0;
  return t;
}

/// b^T E a = 0 over all matches, least squares, with the singular values that an essential matrix has.
std::optional<Eigen::Matrix3d> eight_point(const std::vector<Match>& matches) {
  const Eigen::Matrix3d ta = normalising(matches, &Match::a), tb = normalising(matches, &Match::b);
  Eigen::Matrix<double, 9, 9> normal = Eigen::Matrix<double, 9, 9>::Zero();
  for (const Match& m : matches) {
    const Eigen::Vector3d a = ta * m.a.homogeneous(), b = tb * m.b.homogeneous();
    Eigen::Matrix<double, 9, 1> row;
    row << b.x() * a, b.y() * a, b.z() * a;
    normal.selfadjointView<Eigen::Lower>().rankUpdate(row);
  }
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix<double, 9, 9>> solver(normal);
  if (solver.info() != Eigen::Success) return std::nullopt;
  const Eigen::Matrix<double, 9, 1> e = solver.eigenvectors().col(0);
  Eigen::Matrix3d normalised;
  normalised << e.segment<3>(0).transpose(), e.segment<3>(3).transpose(), e.segment<3>(6).transpose();
  const Eigen::Matrix3d essential = tb.transpose() * normalised * ta;
  const Eigen::JacobiSVD<Eigen::Matrix3d> svd(essential, Eigen::ComputeFullU | Eigen::ComputeFullV);
  if (!(svd.singularValues()(1) > 0.0)) return std::nullopt;
  return Eigen::Matrix3d(svd.matrixU() * Eigen::Vector3d(1.0, 1.0, 0.0).asDiagonal() *
                         svd.matrixV().transpose());
}

/// Sampson's distance, squared: of the two rays from their epipolar lines together, to first order.
double distance2(const Eigen::Matrix3d& essential, const Eigen::Vector2d& a, const Eigen::Vector2d& b) {
  const Eigen::Vector3d line_in_b = essential * a.homogeneous(),
                        line_in_a = essential.transpose() * b.homogeneous();
  const double error = b.homogeneous().dot(line_in_b);
  return error * error / (line_in_b.head<2>().squaredNorm() + line_in_a.head<2>().squaredNorm());
}

/// A tick with its ends the one way and the other way round, as far as the essential matrix tells.
struct Reading {
  bool swapped = false;
  double cost = 0.0;  // sum of the squared distances, each cut off at the tolerance
};

class Search {
 public:
  Search(const std::vector<PairTick>& ticks, const RelativePoseOptions& options)
      : ticks_(ticks), options_(options) {
    for (std::uint32_t t = 0; t < ticks.size(); ++t)
      for (std::size_t i = 0; i < ticks[t].a.size(); ++i) all_.push_back({t, i});
  }

  std::optional<RelativePose> run() {
    if (all_.size() < kFewest || !try_samples()) return std::nullopt;
    best_cost_ = cost_of(best_, 1);
    improve(1);
    if (inliers_of(best_).size() < kFewest) return std::nullopt;
    return pose_of_best();
  }

 private:
  struct Place {
    std::uint32_t tick;
    std::size_t point;
  };

  Reading read(const Eigen::Matrix3d& essential, const PairTick& tick) const {
    const double most = options_.tolerance * options_.tolerance;
    const std::size_t count = tick.a.size();
    std::array<double, 2> cost{};
    for (std::size_t i = 0; i < count; ++i) {
      cost[0] += std::min(most, distance2(essential, tick.a[i], tick.b[i]));
      if (options_.ends_alike && count == 2)
        cost[1] += std::min(most, distance2(essential, tick.a[i], tick.b[1 - i]));
    }
    if (options_.ends_alike && count == 2 && cost[1] < cost[0]) return {true, cost[1]};
    return {false, cost[0]};
  }

  /// Over every `stride`th tick.
  double cost_of(const Eigen::Matrix3d& essential, std::size_t stride) const {
    double cost = 0.0;
    for (std::size_t t = 0; t < ticks_.size(); t += stride) cost += read(essential, ticks_[t]).cost;
    return cost;
  }

  std::vector<Match> inliers_of(const Eigen::Matrix3d& essential) const {
    std::vector<Match> inliers;
    for (std::uint32_t t = 0; t < ticks_.size(); ++t) {
      const PairTick& tick = ticks_[t];
      const bool swapped = read(essential, tick).swapped;
      for (std::size_t i = 0; i < tick.a.size(); ++i) {
        const Eigen::Vector2d& b = tick.b[swapped ? 1 - i : i];
        if (distance2(essential, tick.a[i], b) < options_.tolerance * options_.tolerance)
          inliers.push_back({tick.a[i], b, t});
      }
    }
    return inliers;
  }

  /// Least squares over the inliers of the best so far, as long as that makes it better.
  void improve(std::size_t stride) {
    for (int round = 0; round < 5; ++round) {
      const std::vector<Match> inliers = inliers_of(best_);
      if (inliers.size() < kFewest) return;
      const auto better = eight_point(inliers);
      if (!better) return;
      const double cost = cost_of(*better, stride);
      if (!(cost < best_cost_)) return;
      best_ = *better;
      best_cost_ = cost;
    }
  }

  /// The eight points of a trial; of ends that look alike, guesses which is which.
  std::vector<Match> draw(std::minstd_rand& random) const {
    std::vector<Match> sample;
    for (std::size_t tries = 0; sample.size() < kSample && tries < 4 * kSample; ++tries) {
      const Place place = all_[std::uniform_int_distribution<std::size_t>(0, all_.size() - 1)(random)];
      if (std::any_of(sample.begin(), sample.end(), [&](const Match& m) { return m.tick == place.tick; }))
        continue;
      const PairTick& tick = ticks_[place.tick];
      const bool flip = options_.ends_alike && tick.a.size() == 2 && random() % 2 == 0;
      for (std::size_t i = 0; i < tick.a.size() && sample.size() < kSample; ++i) {
        // With ends alike a tick gives both points for one guess.
        if (!options_.ends_alike && i != place.point) continue;
        sample.push_back({tick.a[i], tick.b[flip ? 1 - i : i], place.tick});
      }
    }
    return sample;
  }

  bool try_samples() {
    std::minstd_rand random(1);
    best_cost_ = std::numeric_limits<double>::infinity();
    const std::size_t stride = (ticks_.size() + kTrialTicks - 1) / kTrialTicks;
    std::uint32_t needed = options_.most_trials;
    for (std::uint32_t trial = 0; trial < needed; ++trial) {
      const std::vector<Match> sample = draw(random);
      if (sample.size() < kSample) return false;
      const auto essential = eight_point(sample);
      if (!essential) continue;
      const double cost = cost_of(*essential, stride);
      if (!(cost < best_cost_)) continue;
      best_cost_ = cost;
      best_ = *essential;
      // Eight noisy points alone are often far off, though no outlier is among them.
      improve(stride);
      needed = std::min(needed, trial + 1 +
                                    trials_left(static_cast<double>(inliers_of(best_).size()) /
                                                static_cast<double>(all_.size())));
    }
    return std::isfinite(best_cost_);
  }

  /// Until kGoodSamples without an outlier are expected, and one was drawn with 99.99 %.
  std::uint32_t trials_left(double share) const {
    double good = std::pow(share, static_cast<double>(kSample));
    if (options_.ends_alike) good /= 16.0;  // four ticks, each guessed
    if (good > 0.999) return kGoodSamples;
    const double trials = std::max(kGoodSamples / good, std::log(1e-4) / std::log(1.0 - good));
    return trials < options_.most_trials ? static_cast<std::uint32_t>(trials) + 10 : options_.most_trials;
  }

  std::optional<RelativePose> pose_of_best() const {
    const Eigen::JacobiSVD<Eigen::Matrix3d> svd(best_, Eigen::ComputeFullU | Eigen::ComputeFullV);
    Eigen::Matrix3d u = svd.matrixU(), v = svd.matrixV(), w;
    if (u.determinant() < 0.0) u.col(2) *= -1.0;
    if (v.determinant() < 0.0) v.col(2) *= -1.0;
    w << 0.0, -1.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0;
    const std::vector<Match> inliers = inliers_of(best_);
    RelativePose best;
    std::vector<double> best_angles;
    for (int k = 0; k < 4; ++k) {
      const Eigen::Matrix3d rotation = u * (k % 2 == 0 ? w : Eigen::Matrix3d(w.transpose())) * v.transpose();
      RelativePose pose;
      pose.b_from_a = {Eigen::Quaterniond(rotation),
                       k < 2 ? Eigen::Vector3d(u.col(2)) : Eigen::Vector3d(-u.col(2))};
      std::vector<double> angles;
      for (const Match& m : inliers) {
        if (!meeting_point(pose.b_from_a, m.a, m.b)) continue;
        const Eigen::Vector3d ray_a = rotation * m.a.homogeneous(), ray_b = m.b.homogeneous();
        angles.push_back(std::atan2(ray_a.cross(ray_b).norm(), ray_a.dot(ray_b)));
      }
      pose.inliers = angles.size();
      if (pose.inliers > best.inliers) best = pose, best_angles = std::move(angles);
    }
    best.points = all_.size();
    if (best.inliers < kFewest || 2 * best.inliers < best.points) return std::nullopt;
    std::nth_element(best_angles.begin(),
                     best_angles.begin() + static_cast<std::ptrdiff_t>(best_angles.size() / 2),
                     best_angles.end());
    best.median_angle_rad = best_angles[best_angles.size() / 2];
    best.planar_share = planar_share(inliers);
    for (const PairTick& tick : ticks_) best.swapped.push_back(read(best_, tick).swapped ? 1 : 0);
    return best;
  }

  double planar_share(const std::vector<Match>& inliers) const {
    std::vector<Eigen::Vector2d> a, b;
    for (const Match& m : inliers) a.push_back(m.a), b.push_back(m.b);
    const auto homography = find_homography(a, b);
    if (!homography) return 0.0;
    std::size_t within = 0;
    for (const Match& m : inliers)
      if (((*homography * m.a.homogeneous()).hnormalized() - m.b).norm() < options_.tolerance) ++within;
    return static_cast<double>(within) / static_cast<double>(inliers.size());
  }

  const std::vector<PairTick>& ticks_;
  const RelativePoseOptions& options_;
  std::vector<Place> all_;
  Eigen::Matrix3d best_ = Eigen::Matrix3d::Zero();
  double best_cost_ = 0.0;
};

}  // namespace

std::optional<Eigen::Vector3d> meeting_point(const Pose& b_from_a, const Eigen::Vector2d& a,
                                             const Eigen::Vector2d& b) {
  const Eigen::Vector3d along_a = a.homogeneous();
  const Eigen::Vector3d along_b = b_from_a.rotation.conjugate() * b.homogeneous();
  const Eigen::Vector3d b_in_a = b_from_a.inverse().translation;
  const double aa = along_a.squaredNorm(), bb = along_b.squaredNorm(), ab = along_a.dot(along_b);
  const double parallel = aa * bb - ab * ab;
  if (!(parallel > 1e-8 * aa * bb)) return std::nullopt;
  const double s = (bb * along_a.dot(b_in_a) - ab * along_b.dot(b_in_a)) / parallel;
  const double t = (ab * along_a.dot(b_in_a) - aa * along_b.dot(b_in_a)) / parallel;
  if (!(s > 0.0) || !(t > 0.0)) return std::nullopt;
  return 0.5 * (s * along_a + b_in_a + t * along_b);
}

std::optional<RelativePose> relative_pose(const std::vector<PairTick>& ticks,
                                          const RelativePoseOptions& options) {
  return Search(ticks, options).run();
}

}  // namespace glint
