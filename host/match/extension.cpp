// SPDX-License-Identifier: MIT
// From a pair of blobs to tuples over all cameras: predict the next camera's pixel, let the blobs there that
// fit join.
#include <algorithm>
#include <cmath>
#include <numbers>

#include <Eigen/LU>

#include "host/geometry/spread.hpp"
#include "host/match/hypotheses.hpp"
#include "host/match/limits.hpp"

namespace glint {
namespace {

constexpr std::size_t kBeam = 16;  // tuples that one pair may lead to at a time; the rest is counted as cut
constexpr double kCertainChi2 = 9.2;   // a lone blob this near (99 %) leaves no reason to try without it
constexpr double kSearchSigmas = 4.3;  // sqrt(kJoinChi2)

double log_2pi() noexcept { return std::log(2.0 * std::numbers::pi); }

}  // namespace

void Hypotheses::grow(const BlobPair& seed) {
  if (already_together(seed.a, seed.b)) return;
  // The pair's own position and covariance: one Gauss-Newton step from the middle between the rays.
  Partial start;
  Eigen::Matrix3d information = Eigen::Matrix3d::Zero();
  Eigen::Vector3d gradient = Eigen::Vector3d::Zero();
  for (std::uint32_t blob : {std::min(seed.a, seed.b), std::max(seed.a, seed.b)}) {
    const MatchBlob& b = table_[blob];
    Eigen::Vector2d pixel;
    Eigen::Matrix<double, 2, 3> jacobian;
    if (!project_outline(cameras_[b.camera], seed.midpoint_in_world, options_.marker_radius_m, pixel,
                         jacobian))
      return;
    const Eigen::Matrix<double, 3, 2> jw = jacobian.transpose() * b.covariance_px2.inverse();
    information.noalias() += jw * jacobian;
    gradient.noalias() += jw * (b.pixel - pixel);
    start.tuple.add(blob);
  }
  start.covariance = information.inverse();
  start.position = seed.midpoint_in_world + start.covariance * gradient;
  if (!start.position.allFinite() || !start.covariance.allFinite()) return;

  order_cameras(start);
  beam_.clear();
  beam_.push_back(start);
  for (const Next& next : order_) {
    grown_.clear();
    for (const Partial& partial : beam_) extend_into(next.camera, partial);
    if (grown_.size() > kBeam) {
      std::partial_sort(grown_.begin(), grown_.begin() + kBeam, grown_.end(),
                        [](const Partial& a, const Partial& b) { return a.score > b.score; });
      cut_ += grown_.size() - kBeam;
      grown_.resize(kBeam);
    }
    beam_.swap(grown_);
  }
  for (const Partial& partial : beam_)
    if (partial.tuple.count >= min_views_) consider(partial.tuple);
}

// The camera that the pair predicts best goes first: fewest blobs lie in its gate. Depends on geometry only,
// not on the order of the cameras in the rig.
void Hypotheses::order_cameras(const Partial& seed) {
  order_.clear();
  const std::uint32_t a = table_[seed.tuple.blobs[0]].camera, b = table_[seed.tuple.blobs[1]].camera;
  for (std::uint32_t camera = 0; camera < cameras_.size(); ++camera) {
    if (camera == a || camera == b || table_.grid(camera).empty()) continue;
    Eigen::Vector2d pixel;
    Eigen::Matrix<double, 2, 3> jacobian;
    if (!project_pinhole(cameras_[camera], seed.position, pixel, jacobian)) continue;
    order_.push_back({(jacobian * seed.covariance * jacobian.transpose()).trace(), camera});
  }
  std::sort(order_.begin(), order_.end(), [](const Next& p, const Next& q) {
    return p.spread != q.spread ? p.spread < q.spread : p.camera < q.camera;
  });
}

void Hypotheses::extend_into(std::size_t camera, const Partial& partial) {
  Eigen::Vector2d pixel;
  Eigen::Matrix<double, 2, 3> jacobian;
  if (!project_outline(cameras_[camera], partial.position, options_.marker_radius_m, pixel, jacobian)) {
    grown_.push_back(partial);
    return;
  }
  const Eigen::Matrix2d spread = jacobian * partial.covariance * jacobian.transpose();
  const double radius = table_.gate_px(camera) + kSearchSigmas * std::sqrt(largest_variance(spread));
  std::size_t joined = 0;
  double nearest = 1e300;
  table_.near(camera, pixel, radius, [&](std::uint32_t blob) {
    const Eigen::Vector2d innovation = table_[blob].pixel - pixel;
    const Eigen::Matrix2d s = spread + table_[blob].covariance_px2;
    const Eigen::Matrix2d s_inverse = s.inverse();
    const double chi2 = innovation.dot(s_inverse * innovation);
    if (!(chi2 <= kJoinChi2)) return;
    Partial& next = grown_.emplace_back(partial);
    next.tuple.add(blob);
    const Eigen::Matrix<double, 3, 2> gain = partial.covariance * jacobian.transpose() * s_inverse;
    next.position += gain * innovation;
    next.covariance -= gain * s * gain.transpose();
    next.score +=
        std::log(kDetected) - log_clutter_[camera] - log_2pi() - 0.5 * std::log(s.determinant()) - 0.5 * chi2;
    nearest = std::min(nearest, chi2);
    ++joined;
  });
  if (joined == 1 && nearest <= kCertainChi2) return;
  Partial& without = grown_.emplace_back(partial);
  without.score += std::log(1.0 - kDetected);
}

}  // namespace glint
