// SPDX-License-Identifier: MIT
// Samples against the truth, tick by tick.
#include "host/sim/identity_score.hpp"

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>

#include <Eigen/Cholesky>

namespace glint {
namespace {

// Room for the bootstrap's sums without allocation.
constexpr double kReserved_s = 120.0;
constexpr std::size_t kSamplesReserved = 4;  // for each marker

double ratio_of(std::uint64_t part, std::uint64_t whole) noexcept {
  return whole == 0 ? 0.0 : static_cast<double>(part) / static_cast<double>(whole);
}
double root_mean(double sum, std::uint64_t count) noexcept {
  return count == 0 ? 0.0 : std::sqrt(sum / static_cast<double>(count));
}

}  // namespace

double IdentityResult::nees_outside() const noexcept {
  if (covariance_faults > 0) return std::numeric_limits<double>::infinity();
  return nees.samples == 0 ? 0.0 : std::max({0.0, nees.low - 1.0, 1.0 - nees.high});
}

IdentityScore::IdentityScore(const Scene& scene, const IdentityOptions& options)
    : scene_(scene),
      options_(options),
      rod_(scene.options().motion == SimMotion::Wand && scene.markers() == 2),
      markers_(scene.markers()),
      mixed_points_(scene, options.image_gate_px),
      history_(scene.markers()),
      nees_(scene.markers(), static_cast<std::size_t>(kReserved_s / options.block_s)),
      gap_frames_(scene.markers()) {
  measured_.reserve(kSamplesReserved * scene.markers());
  sample_of_measured_.reserve(kSamplesReserved * scene.markers());
}

void IdentityScore::add(std::uint64_t tick, std::span<const IdentitySample> samples) {
  scene_.truth(tick, truth_);
  for (std::size_t m = 0; m < markers_.size(); ++m) markers_[m] = truth_.markers[m].position_in_world;
  measured_.clear();
  sample_of_measured_.clear();
  for (const IdentitySample& sample : samples) {
    ambiguous_ += sample.ambiguous ? 1u : 0u;
    if (sample.predicted) continue;
    measured_.push_back(sample.position_in_world);
    sample_of_measured_.push_back(&sample);
  }
  assignment_.solve(measured_, markers_, options_.gate_m);
  ++counts_.ticks;
  count_expected();
  // Where predictions belong is what was known before this tick.
  for (const IdentitySample& sample : samples)
    if (sample.predicted) count_predicted(sample);
  for (std::size_t place = 0; place < measured_.size(); ++place)
    count_measured(*sample_of_measured_[place], place);
  if (rod_) count_pair();
}

void IdentityScore::count_expected() {
  bool complete = true;
  for (std::size_t m = 0; m < markers_.size(); ++m) {
    const bool found = assignment_.sample_of(m) >= 0;
    if (found) gap_frames_[m] = 0;
    if (std::popcount(truth_.markers[m].visible & truth_.delivered) < 2) continue;
    ++counts_.expected;
    counts_.found += found ? 1u : 0u;
    if (found) continue;
    complete = false;
    counts_.longest_gap_frames = std::max(counts_.longest_gap_frames, ++gap_frames_[m]);
  }
  count_recovery(complete);
}

void IdentityScore::count_recovery(bool complete) {
  for (std::uint32_t c = 0; c < scene_.cameras(); ++c) {
    if ((truth_.delivered >> c & 1u) == 0) {
      ++away_[c];
      continue;
    }
    if (away_[c] >= options_.away_ticks) {
      ++counts_.cameras_back;
      recovering_ = true;
      recovering_frames_ = 0;
    }
    away_[c] = 0;
  }
  if (!recovering_) return;
  recovering_ = !complete;
  if (recovering_) counts_.recovery_frames = std::max(counts_.recovery_frames, ++recovering_frames_);
}

void IdentityScore::count_measured(const IdentitySample& sample, std::size_t place) {
  ++counts_.measured;
  if (sample.cameras != 0) {
    ++counts_.mixed_checked;
    if (mixed_points_.mixed(truth_, sample.position_in_world, sample.cameras)) ++counts_.mixed;
  }
  const std::int32_t assigned = assignment_.marker_of(place);
  if (assigned < 0) {
    ++(assignment_.markers_near(place) == 0 ? counts_.ghosts : counts_.doubled);
    history_.elsewhere(sample.id, sample.ambiguous);
    return;
  }
  const auto marker = static_cast<std::uint32_t>(assigned);
  const Eigen::Vector3d error = sample.position_in_world - markers_[marker];
  ++matched_;
  sum_error2_ += error.squaredNorm();
  counts_.worst_m = std::max(counts_.worst_m, error.norm());
  errors_.add(error.norm());
  count_normalised_error(sample, marker, error);
  if (assignment_.markers_near(place) == 1) {
    history_.on_marker(sample.id, marker, sample.ambiguous);
  } else {
    history_.elsewhere(sample.id, sample.ambiguous);
  }
}

void IdentityScore::count_predicted(const IdentitySample& sample) {
  ++counts_.predicted;
  history_.elsewhere(sample.id, sample.ambiguous);
  const std::optional<std::uint32_t> marker = history_.marker_of(sample.id);
  if (!marker) {
    ++counts_.predicted_of_nothing;
    return;
  }
  const double error_m = (sample.position_in_world - markers_[*marker]).norm();
  sum_predicted_error2_ += error_m * error_m;
  counts_.predicted_worst_m = std::max(counts_.predicted_worst_m, error_m);
}

void IdentityScore::count_normalised_error(const IdentitySample& sample, std::uint32_t marker,
                                           const Eigen::Vector3d& error) {
  if (sample.covariance_m2.isZero(0.0)) return;
  const Eigen::LLT<Eigen::Matrix3d> factors(sample.covariance_m2);
  const double squared = error.dot(factors.solve(error));
  if (factors.info() != Eigen::Success || !std::isfinite(squared)) {
    ++counts_.covariance_faults;
    return;
  }
  const auto block = static_cast<std::uint64_t>(scene_.mid_exposure_s(truth_.tick) / options_.block_s);
  nees_.add(marker, block, squared / 3.0);
}

void IdentityScore::count_pair() {
  const std::int32_t first = assignment_.sample_of(0), second = assignment_.sample_of(1);
  if (first < 0 || second < 0) return;
  const double measured_m =
      (measured_[static_cast<std::size_t>(first)] - measured_[static_cast<std::size_t>(second)]).norm();
  const double error_m = std::abs(measured_m - (markers_[0] - markers_[1]).norm());
  ++counts_.pairs;
  sum_pair_error2_ += error_m * error_m;
  counts_.pair_worst_m = std::max(counts_.pair_worst_m, error_m);
}

IdentityResult IdentityScore::result() const {
  IdentityResult result = counts_;
  const std::uint64_t samples = result.measured + result.predicted;
  result.ids = history_.counts();
  result.recall = ratio_of(result.found, result.expected);
  result.ghosts_per_tick = ratio_of(result.ghosts, result.ticks);
  result.doubled_per_tick = ratio_of(result.doubled, result.ticks);
  result.rms_m = root_mean(sum_error2_, matched_);
  result.median_m = errors_.median();
  result.q999_m = errors_.quantile(0.999);
  result.ambiguous_share = ratio_of(ambiguous_, samples);
  result.predicted_share = ratio_of(result.predicted, samples);
  result.predicted_rms_m = root_mean(sum_predicted_error2_, result.predicted - result.predicted_of_nothing);
  result.nees = nees_.result(options_.bootstrap_rounds, options_.bootstrap_seed);
  result.pair_rms_m = root_mean(sum_pair_error2_, result.pairs);
  return result;
}

}  // namespace glint
