// SPDX-License-Identifier: MIT
// Likelihoods of the three assumptions and their fits.
#include "host/health/explanation.hpp"

#include <algorithm>
#include <array>
#include <bitset>
#include <cmath>
#include <numbers>

#include <Eigen/Cholesky>
#include <Eigen/LU>

namespace glint::health {
namespace {

// How often a point that should be seen has a blob of its own: only its logarithm counts, as in the matcher.
constexpr double kDetected = 0.9;
// A knocked camera also moves a little, which shifts near points more than far ones, and the offset of a
// large turn is not quite linear: a tenth of the offset is left to that.
constexpr double kTurnShare = 0.1;
constexpr double kLargestTurn_rad = 1.1 * kReach_rad;
// Weak knowledge that a camera does not spin about its own axis, for two comparisons that lie close together.
constexpr double kTurnPrior_rad = 0.1;
// Velocities come from a filter, which lags behind in bounces and throws, and paths are not straight.
constexpr double kDelayShare = 0.1, kVelocitySd_m_s = 0.1, kAcceleration_m_s2 = 10.0;
constexpr double kLongestDelay_s = 0.1;
constexpr double kLeastImageSpeed_px_s = 50.0;  // slower ones tell of a delay what is lost in noise

constexpr int kTurnTrials = 40, kDelayTrials = 30, kRefinements = 3;
constexpr int kDraws = 8;               // for a comparison that tells something
constexpr std::size_t kTrialSize = 64;  // comparisons that a hypothesis is tried on

struct AsIs {
  Eigen::Vector2d offset(const Comparison&) const noexcept { return Eigen::Vector2d::Zero(); }
  double variance_px2(const Comparison&, const Eigen::Vector2d&) const noexcept { return 0.0; }
};

// A camera turned by a small vector t sees a point x of its old frame at x - t x x.
struct Turn {
  double fx_px, fy_px;
  Eigen::Vector3d turn_rad = Eigen::Vector3d::Zero();

  Eigen::Matrix<double, 2, 3> by_turn(const Comparison& c) const noexcept {
    const double u = c.at.x(), v = c.at.y();
    Eigen::Matrix<double, 2, 3> j;
    j << fx_px * u * v, -fx_px * (1.0 + u * u), fx_px * v,  //
        fy_px * (1.0 + v * v), -fy_px * u * v, -fy_px * u;
    return j;
  }
  Eigen::Vector2d offset(const Comparison& c) const noexcept { return by_turn(c) * turn_rad; }
  double variance_px2(const Comparison&, const Eigen::Vector2d& offset) const noexcept {
    return kTurnShare * kTurnShare * offset.squaredNorm();
  }
};

struct Delay {
  double late_s = 0.0;

  Eigen::Vector2d offset(const Comparison& c) const noexcept { return late_s * c.velocity_px_s; }
  double variance_px2(const Comparison& c, const Eigen::Vector2d& offset) const noexcept {
    const double drift_m = std::hypot(kVelocitySd_m_s * late_s, 0.5 * kAcceleration_m_s2 * late_s * late_s);
    return kDelayShare * kDelayShare * offset.squaredNorm() + std::pow(c.px_per_m * drift_m, 2);
  }
};

bool tells_of_delay(const Comparison& c) noexcept {
  return c.blobs > 0 && c.velocity_px_s.squaredNorm() > kLeastImageSpeed_px_s * kLeastImageSpeed_px_s;
}

struct Nearest {
  double chi2 = 1e300;
  std::size_t blob = 0;
};

Eigen::Matrix2d covariance(const Comparison& c, double noise, double extra_px2) noexcept {
  return noise * noise * c.covariance_px2 + extra_px2 * Eigen::Matrix2d::Identity();
}

Nearest nearest(const Comparison& c, const Eigen::Vector2d& offset, const Eigen::Matrix2d& inverse) noexcept {
  Nearest best;
  for (std::size_t k = 0; k < c.blobs; ++k) {
    const Eigen::Vector2d d = c.offset_px[k] - offset;
    const double chi2 = d.dot(inverse * d);
    if (chi2 < best.chi2) best = {chi2, k};
  }
  return best;
}

constexpr std::size_t kCells = 1024;

/// Adds up the means of the parts of an image.
class CellMeans {
 public:
  void add(std::size_t cell, double value) noexcept {
    sums_[cell] += value;
    ++counts_[cell];
  }
  double total() const noexcept {
    double total = 0.0;
    for (std::size_t n = 0; n < kCells; ++n)
      if (counts_[n] > 0) total += sums_[n] / counts_[n];
    return total;
  }

 private:
  std::array<double, kCells> sums_{};
  std::array<std::uint16_t, kCells> counts_{};
};

template <typename Model>
Account account_of(const Model& model, const ComparisonWindow& window, double noise) noexcept {
  Account account;
  CellMeans moved, unmoved;
  std::bitset<kCells> gained;
  double squares = 0.0;
  for (std::size_t n = 0; n < window.size(); ++n) {
    const Comparison& c = window[n];
    if (c.blobs == 0) continue;
    ++account.seen;
    const Eigen::Vector2d offset = model.offset(c);
    const Eigen::Matrix2d s = covariance(c, noise, model.variance_px2(c, offset));
    const Eigen::Matrix2d inverse = s.inverse();
    double density_moved = 0.0, density_unmoved = 0.0, least = 1e300;
    for (std::size_t k = 0; k < c.blobs; ++k) {
      const Eigen::Vector2d d = c.offset_px[k] - offset;
      const double chi2 = d.dot(inverse * d);
      density_moved += std::exp(-0.5 * chi2);
      density_unmoved += std::exp(-0.5 * c.offset_px[k].dot(inverse * c.offset_px[k]));
      least = std::min(least, chi2);
    }
    const double scale =
        kDetected / (c.clutter_per_px2 * 2.0 * std::numbers::pi * std::sqrt(s.determinant()));
    const std::size_t cell = c.cell % kCells;
    moved.add(cell, std::log(1.0 - kDetected + scale * density_moved));
    unmoved.add(cell, std::log(1.0 - kDetected + scale * density_unmoved));
    squares += offset.squaredNorm();
    if (least > kNearChi2) continue;
    ++account.explained;
    if (misfit2(c, noise) <= kNearChi2) continue;
    ++account.gained;
    gained.set(cell);
  }
  account.log_likelihood = moved.total();
  account.log_likelihood_unmoved = unmoved.total();
  account.gained_cells = static_cast<std::uint32_t>(gained.count());
  if (account.seen > 0) account.offset_px = std::sqrt(squares / account.seen);
  return account;
}

/// How much of a sample of the window a hypothesis explains.
template <typename Model>
unsigned supporters(const Model& model, const ComparisonWindow& window, double noise) noexcept {
  unsigned count = 0;
  const std::size_t step = std::max<std::size_t>(1, window.size() / kTrialSize);
  for (std::size_t n = 0; n < window.size(); n += step) {
    const Comparison& c = window[n];
    const Eigen::Vector2d offset = model.offset(c);
    // A round covariance will do here.
    const double limit =
        kNearChi2 * (0.5 * noise * noise * c.covariance_px2.trace() + model.variance_px2(c, offset));
    for (std::size_t k = 0; k < c.blobs; ++k) {
      if ((c.offset_px[k] - offset).squaredNorm() > limit) continue;
      ++count;
      break;
    }
  }
  return count;
}

/// Calls use(comparison, blob's offset, inverse covariance) for each comparison that the model explains.
template <typename Model, typename Use>
void for_explained(const Model& model, const ComparisonWindow& window, double noise, Use&& use) noexcept {
  for (std::size_t n = 0; n < window.size(); ++n) {
    const Comparison& c = window[n];
    const Eigen::Vector2d offset = model.offset(c);
    const Eigen::Matrix2d inverse = covariance(c, noise, model.variance_px2(c, offset)).inverse();
    const Nearest best = nearest(c, offset, inverse);
    if (best.chi2 <= kNearChi2) use(c, c.offset_px[best.blob], inverse);
  }
}

}  // namespace

double misfit2(const Comparison& c, double noise) noexcept {
  return nearest(c, Eigen::Vector2d::Zero(), covariance(c, noise, 0.0).inverse()).chi2;
}

std::size_t Explainer::pick(std::size_t count) noexcept {
  // Marsaglia, Xorshift RNGs, Journal of Statistical Software 8(14), 2003.
  random_ ^= random_ << 13;
  random_ ^= random_ >> 7;
  random_ ^= random_ << 17;
  return static_cast<std::size_t>((random_ >> 32) * count >> 32);
}

Account Explainer::all_is_well(const ComparisonWindow& window, double noise) const noexcept {
  return account_of(AsIs{}, window, noise);
}

TurnAccount Explainer::turned(const ComparisonWindow& window, double noise) noexcept {
  Turn best{fx_px_, fy_px_};
  unsigned most = 0;
  for (int trial = 0; trial < kTurnTrials && window.size() > 1; ++trial) {
    Turn turn{fx_px_, fy_px_};
    Eigen::Matrix3d normal = Eigen::Matrix3d::Identity() / (kTurnPrior_rad * kTurnPrior_rad);
    Eigen::Vector3d right = Eigen::Vector3d::Zero();
    for (int n = 0; n < 2; ++n) {
      const Comparison& c = window[pick(window.size())];
      if (c.blobs == 0) continue;
      const Eigen::Matrix<double, 2, 3> j = turn.by_turn(c);
      normal += j.transpose() * j;
      right += j.transpose() * c.offset_px[pick(c.blobs)];
    }
    turn.turn_rad = normal.ldlt().solve(right);
    if (!(turn.turn_rad.norm() <= kLargestTurn_rad)) continue;
    const unsigned count = supporters(turn, window, noise);
    if (count <= most) continue;
    most = count;
    best = turn;
  }
  for (int n = 0; n < kRefinements && most > 0; ++n) {
    Eigen::Matrix3d normal = Eigen::Matrix3d::Identity() / (kTurnPrior_rad * kTurnPrior_rad);
    Eigen::Vector3d right = Eigen::Vector3d::Zero();
    for_explained(best, window, noise,
                  [&](const Comparison& c, const Eigen::Vector2d& d, const auto& inverse) {
                    const Eigen::Matrix<double, 2, 3> j = best.by_turn(c);
                    normal += j.transpose() * inverse * j;
                    right += j.transpose() * inverse * d;
                  });
    best.turn_rad = normal.ldlt().solve(right);
  }
  TurnAccount account;
  static_cast<Account&>(account) = account_of(best, window, noise);
  account.turn_rad = best.turn_rad;
  return account;
}

DelayAccount Explainer::delayed(const ComparisonWindow& window, double noise) noexcept {
  Delay best;
  unsigned most = 0;
  for (int trial = 0; trial < kDelayTrials && window.size() > 0; ++trial) {
    std::size_t n = pick(window.size());
    for (int draw = 0; draw < kDraws && !tells_of_delay(window[n]); ++draw) n = pick(window.size());
    const Comparison& c = window[n];
    if (!tells_of_delay(c)) continue;
    const double speed2 = c.velocity_px_s.squaredNorm();
    const Delay delay{c.offset_px[pick(c.blobs)].dot(c.velocity_px_s) / speed2};
    if (!(std::abs(delay.late_s) <= kLongestDelay_s)) continue;
    const unsigned count = supporters(delay, window, noise);
    if (count <= most) continue;
    most = count;
    best = delay;
  }
  for (int n = 0; n < kRefinements && most > 0; ++n) {
    double normal = 0.0, right = 0.0;
    for_explained(best, window, noise,
                  [&](const Comparison& c, const Eigen::Vector2d& d, const auto& inverse) {
                    const Eigen::Vector2d weighted = inverse * c.velocity_px_s;
                    normal += weighted.dot(c.velocity_px_s);
                    right += weighted.dot(d);
                  });
    if (normal > 0.0) best.late_s = std::clamp(right / normal, -kLongestDelay_s, kLongestDelay_s);
  }
  DelayAccount account;
  static_cast<Account&>(account) = account_of(best, window, noise);
  account.late_s = best.late_s;
  return account;
}

}  // namespace glint::health
