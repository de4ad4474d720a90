// SPDX-License-Identifier: MIT
// Prediction, mixing and correction of one marker's motion.
#include "host/track/motion.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include <Eigen/LU>

namespace glint {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

enum : std::size_t { kFree, kSteady, kGentle, kPull, kRough };

// Process noise in units of the usual acceleration. That of a marker in free flight does not change, that of
// one which is moved steadily hardly, of one that is swung several times a second somewhat, and of one that
// is pulled about thirty times a second; one that is pulled about has five times as much, another at every
// exposure. Steps of that size keep each motion near to one of the models: one that thinks a marker more
// restless than it is smooths little, one that thinks it calmer lags behind.
constexpr std::array<double, kRough> kChanges_per_s{0.003, 0.05, 1.0, 30.0};
constexpr double kRoughShare = 5.0;
// Changes per second from one kind of motion (row) to another (column). Seldom: what a model that was not in
// force adds to the others each time is what limits how much they smooth.
constexpr double kRate_per_s[kMotionModes][kMotionModes] = {{0.0, 0.3, 0.1, 0.1, 1.0},
                                                            {0.3, 0.0, 0.3, 0.1, 1.0},
                                                            {0.1, 0.3, 0.0, 0.3, 1.0},
                                                            {0.1, 0.1, 0.3, 0.0, 1.0},
                                                            {5.0, 5.0, 5.0, 5.0, 0.0}};
constexpr std::array<double, kMotionModes> kFirstWeights{0.1, 0.2, 0.2, 0.2, 0.3};
constexpr double kLeastWeight = 1e-10;  // a model that was right a second ago may be so again: never zero
// A marker that hits something goes on in any direction, about as fast as before, from some moment between
// two exposures: once in so many exposures, looked for in so many after it was last seen.
constexpr double kImpactWeight = 0.01, kImpactSpeedFactor = 1.2, kImpactSpeedOffset_m_s = 1.0;
constexpr unsigned kImpactSteps = 4;
constexpr double kSpeedKept =
    0.9;  // per exposure, of the largest speed of late: corners come as two impacts in a row
// A position that neither flight nor a pull explains (once in 1,000, three degrees of freedom) may be that
// of a marker that hit something just before.
constexpr double kSurpriseChi2 = 16.3;
constexpr double kImpactAcceleration_m_s2 = 30.0;  // afterwards

// Rounding must not add up: what is not symmetric grows.
Matrix3d symmetric(const Matrix3d& m) noexcept { return 0.5 * (m + m.transpose()); }

}  // namespace

Motion::Motion(const Vector3d& position, const Matrix3d& covariance_m2, double velocity_sd_m_s,
               double acceleration_sd_m_s2) noexcept {
  for (std::size_t i = 0; i < kMotionModes; ++i) {
    Mode& m = modes_[i];
    m.weight = kFirstWeights[i];
    m.p = position;
    m.v = m.a = Vector3d::Zero();
    m.pp = covariance_m2;
    m.pv = m.pa = m.va = Matrix3d::Zero();
    m.vv = velocity_sd_m_s * velocity_sd_m_s * Matrix3d::Identity();
    m.aa = (i == kRough ? 0.0 : acceleration_sd_m_s2 * acceleration_sd_m_s2) * Matrix3d::Identity();
  }
  summarise();
}

// Each model starts from what all of them know, weighted by how likely each was the one in force before.
void Motion::mix(double seconds) noexcept {
  double to[kMotionModes][kMotionModes];  // weight of a marker that was i and is j
  std::array<double, kMotionModes> total{};
  for (std::size_t i = 0; i < kMotionModes; ++i) {
    double leaves = 0.0;
    for (std::size_t j = 0; j < kMotionModes; ++j) {
      if (j == i) continue;
      to[i][j] = modes_[i].weight * (1.0 - std::exp(-kRate_per_s[i][j] * seconds));
      leaves += to[i][j];
    }
    to[i][i] = std::max(0.0, modes_[i].weight - leaves);
    for (std::size_t j = 0; j < kMotionModes; ++j) total[j] += to[i][j];
  }
  const std::array<Mode, kMotionModes> before = modes_;
  for (std::size_t j = 0; j < kMotionModes; ++j) {
    Mode& m = modes_[j];
    m.weight = total[j];
    if (!(total[j] > 0.0)) continue;
    m.p = m.v = Vector3d::Zero();
    for (std::size_t i = 0; i < kMotionModes; ++i) {
      m.p += to[i][j] / total[j] * before[i].p;
      m.v += to[i][j] / total[j] * before[i].v;
    }
    m.pp = m.pv = m.vv = Matrix3d::Zero();
    for (std::size_t i = 0; i < kMotionModes; ++i) {
      const double share = to[i][j] / total[j];
      const Vector3d dp = before[i].p - m.p, dv = before[i].v - m.v;
      m.pp += share * (before[i].pp + dp * dp.transpose());
      m.pv += share * (before[i].pv + dp * dv.transpose());
      m.vv += share * (before[i].vv + dv * dv.transpose());
    }
    if (j == kRough) continue;
    // Where the acceleration is not known, it is what the others think, apart from everything else.
    const double knowing = total[j] - to[kRough][j];
    if (!(knowing > 0.0)) continue;
    m.a = Vector3d::Zero();
    for (std::size_t i = 0; i < kRough; ++i) m.a += to[i][j] / knowing * before[i].a;
    m.pa = m.va = m.aa = Matrix3d::Zero();
    for (std::size_t i = 0; i < kRough; ++i) {
      const double share = to[i][j] / total[j];
      const Vector3d da = before[i].a - m.a;
      m.pa += share * (before[i].pa + (before[i].p - m.p) * da.transpose());
      m.va += share * (before[i].va + (before[i].v - m.v) * da.transpose());
      m.aa += to[i][j] / knowing * (before[i].aa + da * da.transpose());
    }
  }
}

// Acceleration constant within the step (Bar-Shalom, Li, Kirubarajan, Estimation with Applications to
// Tracking and Navigation, 2001, 6.3.2 and 6.3.3).
void Motion::advance(double seconds, double acceleration_sd_m_s2) noexcept {
  if (!(seconds > 0.0)) return;
  unseen_s_ += seconds;
  ++unseen_steps_;
  mix(seconds);
  const double t = seconds, h = 0.5 * t * t;
  for (std::size_t i = 0; i < kMotionModes; ++i) {
    Mode& m = modes_[i];
    double q = 0.0;
    if (i != kRough) {
      m.p += t * m.v + h * m.a;
      m.v += t * m.a;
      // F P F' from the top left down, so that each block still finds the old ones that it needs.
      const Matrix3d pv = m.pv, pa = m.pa, vv = m.vv, va = m.va;
      m.pp += t * (pv + pv.transpose()) + h * (pa + pa.transpose()) + t * t * vv +
              t * h * (va + va.transpose()) + h * h * m.aa;
      m.pv = pv + t * pa + t * vv + t * t * va + h * va.transpose() + h * t * m.aa;
      m.pa = pa + t * va + h * m.aa;
      m.vv = vv + t * (va + va.transpose()) + t * t * m.aa;
      m.va = va + t * m.aa;
      q = std::pow(acceleration_sd_m_s2 * kChanges_per_s[i] * t, 2);
      m.pa.diagonal().array() += q * h;
      m.va.diagonal().array() += q * t;
      m.aa.diagonal().array() += q;
    } else {
      m.p += t * m.v;
      m.pp += t * (m.pv + m.pv.transpose()) + t * t * m.vv;
      m.pv += t * m.vv;
      q = std::pow(acceleration_sd_m_s2 * kRoughShare, 2);
    }
    m.pp.diagonal().array() += q * h * h;
    m.pv.diagonal().array() += q * h * t;
    m.vv.diagonal().array() += q * t * t;
  }
  summarise();
}

double Motion::impact_reach_m() const noexcept {
  if (unseen_steps_ > kImpactSteps) return 0.0;
  return (kImpactSpeedFactor * speed_m_s_ + kImpactSpeedOffset_m_s) * unseen_s_;
}

Matrix3d Motion::impact_covariance() const noexcept {
  // Between straight on and straight back: the deviation is at most twice the reach, along some direction.
  const double sd_m = impact_reach_m() / std::numbers::sqrt3;
  return position_covariance_ + sd_m * sd_m * Matrix3d::Identity();
}

double Motion::correct(const PositionEvidence& evidence) noexcept {
  std::array<double, kMotionModes> log_weight;
  double best = -std::numeric_limits<double>::infinity(), nearest_smooth = -best;
  struct Seen {
    Matrix3d posterior;
    Vector3d position;
    double distance2, log_ratio;
  };
  const auto look = [&evidence](const Vector3d& expected, const Matrix3d& covariance, const Matrix3d& prior) {
    Seen seen;
    seen.posterior = (prior + evidence.information_per_m2).inverse();
    seen.posterior = symmetric(seen.posterior);
    const Vector3d away = expected - evidence.near_in_world, pull = prior * away;
    const Vector3d sum = evidence.gradient_per_m + pull;
    seen.position = evidence.near_in_world + seen.posterior * sum;
    seen.distance2 = away.dot(pull) - sum.dot(seen.posterior * sum);
    seen.log_ratio =
        -0.5 * seen.distance2 + 0.5 * std::log(seen.posterior.determinant() / covariance.determinant());
    return seen;
  };
  double log_impact = best;
  Seen impact;
  if (impact_reach_m() > 0.0) {
    const Matrix3d covariance = impact_covariance();
    impact = look(position_, covariance, covariance.inverse());
    log_impact = std::log(kImpactWeight) + impact.log_ratio;
    best = log_impact;
  }
  for (std::size_t i = 0; i < kMotionModes; ++i) {
    Mode& m = modes_[i];
    const Matrix3d prior = m.pp.inverse();
    const Seen seen = look(m.p, m.pp, prior);
    if (i != kRough) nearest_smooth = std::min(nearest_smooth, seen.distance2);
    log_weight[i] = std::log(std::max(m.weight, kLeastWeight)) + seen.log_ratio;
    best = std::max(best, log_weight[i]);
    // What is learnt of the position moves the rest as far as they are correlated; G = cov(x, p) cov(p)^-1.
    const Vector3d gained = seen.position - m.p;
    const Matrix3d vp = m.pv.transpose() * prior;
    const Matrix3d lost = m.pp - seen.posterior;
    m.p += gained;
    m.v += vp * gained;
    m.vv -= vp * lost * vp.transpose();
    m.pv = seen.posterior * vp.transpose();
    m.pp = seen.posterior;
    if (i != kRough) {
      const Matrix3d ap = m.pa.transpose() * prior;
      m.a += ap * gained;
      m.aa -= ap * lost * ap.transpose();
      m.va -= vp * lost * ap.transpose();
      m.pa = seen.posterior * ap.transpose();
      m.aa = symmetric(m.aa);
    }
    m.vv = symmetric(m.vv);
  }
  double total = 0.0;
  for (std::size_t i = 0; i < kMotionModes; ++i) {
    modes_[i].weight = std::exp(log_weight[i] - best);
    total += modes_[i].weight;
  }
  const double impact_weight = std::exp(log_impact - best);
  const double log_likelihood = best + std::log(total + impact_weight);
  const double speed_m_s = speed_m_s_ + kImpactSpeedOffset_m_s;
  if (impact_weight > total) {
    const unsigned impacts = impacts_ + 1;
    *this = Motion(impact.position, impact.posterior, speed_m_s, kImpactAcceleration_m_s2);
    impacts_ = impacts;
    speed_m_s_ = speed_m_s - kImpactSpeedOffset_m_s;
    return log_likelihood;
  }
  for (Mode& m : modes_) m.weight = std::max(kLeastWeight, m.weight / total);
  if (nearest_smooth > kSurpriseChi2) modes_[kRough].vv.diagonal().array() += speed_m_s * speed_m_s;
  summarise();
  speed_m_s_ = std::max(velocity_.norm(), kSpeedKept * speed_m_s_);
  unseen_s_ = 0.0;
  unseen_steps_ = 0;
  return log_likelihood;
}

void Motion::summarise() noexcept {
  position_ = velocity_ = Vector3d::Zero();
  double total = 0.0;
  for (const Mode& m : modes_) {
    position_ += m.weight * m.p;
    velocity_ += m.weight * m.v;
    total += m.weight;
  }
  position_ /= total;
  velocity_ /= total;
  position_covariance_ = Matrix3d::Zero();
  for (const Mode& m : modes_)
    position_covariance_ += m.weight / total * (m.pp + (m.p - position_) * (m.p - position_).transpose());
}

double Motion::log_density(const Vector3d& measured, const Matrix3d& covariance_m2) const noexcept {
  double density = 0.0;
  for (const Mode& m : modes_) {
    const Matrix3d s = m.pp + covariance_m2;
    const Vector3d d = measured - m.p;
    density += m.weight * std::exp(-0.5 * d.dot(s.inverse() * d)) / std::sqrt(s.determinant());
  }
  if (impact_reach_m() > 0.0) {
    const Matrix3d s = impact_covariance() + covariance_m2;
    const Vector3d d = measured - position_;
    density += kImpactWeight * std::exp(-0.5 * d.dot(s.inverse() * d)) / std::sqrt(s.determinant());
  }
  return std::log(std::max(density, 1e-300)) - 1.5 * std::log(2.0 * std::numbers::pi);
}

double Motion::distance2(const Vector3d& measured, const Matrix3d& covariance_m2) const noexcept {
  double nearest = std::numeric_limits<double>::infinity();
  for (const Mode& m : modes_) {
    const Vector3d d = measured - m.p;
    nearest = std::min(nearest, d.dot(Matrix3d(m.pp + covariance_m2).inverse() * d));
  }
  return nearest;
}

std::array<PredictedMode, kMotionModes> Motion::modes() const noexcept {
  std::array<PredictedMode, kMotionModes> modes;
  for (std::size_t i = 0; i < kMotionModes; ++i)
    modes[i] = {modes_[i].weight, modes_[i].p, modes_[i].pp, i == kRough};
  return modes;
}

}  // namespace glint
