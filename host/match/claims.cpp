// SPDX-License-Identifier: MIT
// Gates, a beam over the cameras, and the likelihood of what comes out.
#include "host/match/claims.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include <Eigen/LU>

#include "host/geometry/spread.hpp"
#include "host/match/limits.hpp"
#include "host/match/odd_sizes.hpp"

namespace glint {
namespace {

// A prediction that is this uncertain in some camera, or that finds so many blobs, cannot tell them apart:
// its marker is found without it, and the tracker joins them.
constexpr double kVaguePx = 40.0;
constexpr std::uint32_t kVagueBlobs = 8;
// Of the blobs this near to the expected place, so many are of other markers that no track claims.
constexpr double kAround_px = 40.0, kOthersShare = 0.3;
constexpr std::size_t kBeam = 8;  // choices of one track that are followed at a time
constexpr double kCertainChi2 =
    9.2;  // a lone, uncontested blob this near (99 %) leaves no reason to try without it
constexpr double kSharp_px = 2.0;  // one standard deviation: hardly any other marker shows there
constexpr std::size_t kTracksReserved = 512;

double log_2pi() noexcept { return std::log(2.0 * std::numbers::pi); }

std::span<const PredictedMode> modes_of(const Prediction& prediction, PredictedMode& single) noexcept {
  if (prediction.mode_count > 0) return {prediction.modes.data(), prediction.mode_count};
  single = {1.0, prediction.position_in_world, prediction.covariance_m2, false};
  return {&single, 1};
}

}  // namespace

Claims::Claims(std::span<const Camera> cameras, const MatchOptions& options, const BlobTable& table,
               const ExpectedViews& expected)
    : cameras_(cameras),
      options_(options),
      table_(table),
      expected_(expected),
      log_clutter_(cameras.size(), 0.0) {
  // Room for busy frames, so that a rare one does not have to ask for it.
  sights_.reserve(kTracksReserved * cameras.size());
  candidates_.reserve(kTracksReserved * cameras.size());
  claims_.reserve(kTracksReserved);
  beam_.reserve(kBeam * (kVagueBlobs + 1));
  grown_.reserve(kBeam * (kVagueBlobs + 1));
}

Observation Claims::observation(const Prediction& prediction, std::uint32_t blob) const noexcept {
  const MatchBlob& b = table_[blob];
  Observation view{&cameras_[b.camera], b.normalized, b.covariance_px2};
  if (b.camera < prediction.bias.size()) {
    const ViewBias& bias = prediction.bias[b.camera];
    const CameraCalibration& c = cameras_[b.camera].calibration();
    view.normalized -= Eigen::Vector2d(bias.px.x() / c.fx_px, bias.px.y() / c.fy_px);
    view.covariance_px2.diagonal().array() += bias.variance_px2 - table_.calibration_variance_px2(b.camera);
  }
  return view;
}

void Claims::find(std::span<const Prediction> predictions, std::span<const std::uint8_t> settled,
                  ClaimViews views) {
  const bool single_view = views != ClaimViews::Several;
  least_views_ = single_view ? 1 : 2;
  sharp_only_ = views == ClaimViews::SharpSingle;
  claims_.clear();
  sights_.clear();
  candidates_.clear();
  first_sight_.clear();
  for (std::size_t camera = 0; camera < cameras_.size(); ++camera) {
    const CameraCalibration& c = cameras_[camera].calibration();
    const double area = std::max(1.0, static_cast<double>(c.width_px) * static_cast<double>(c.height_px));
    log_clutter_[camera] =
        std::log(kClutterShare * std::max(1.0, static_cast<double>(table_.free_blobs(camera))) / area);
  }
  for (std::uint32_t k = 0; k < predictions.size(); ++k) {
    const std::size_t sights = sights_.size(), candidates = candidates_.size();
    first_sight_.push_back(static_cast<std::uint32_t>(sights));
    if (settled[k] != 0 || (single_view && !predictions[k].single_view) || collect(k, predictions[k]))
      continue;
    sights_.resize(sights);
    candidates_.resize(candidates);
  }
  first_sight_.push_back(static_cast<std::uint32_t>(sights_.size()));
  count_wishes();
  for (std::uint32_t k = 0; k < predictions.size(); ++k)
    search(k, predictions[k],
           std::span(sights_).subspan(first_sight_[k], first_sight_[k + 1] - first_sight_[k]));
}

// Blobs within the gates of one prediction; false if they are of no use.
bool Claims::collect(std::uint32_t number, const Prediction& prediction) {
  if (!prediction.position_in_world.allFinite() || !prediction.covariance_m2.allFinite()) return false;
  for (std::uint32_t camera = 0; camera < cameras_.size(); ++camera) {
    const ExpectedView& expected = expected_.of(number, camera);
    if (!expected.in_front || table_.grid(camera).empty()) continue;
    if (sharp_only_ && !(largest_variance(expected.spread_px2) < kSharp_px * kSharp_px)) continue;
    Sight sight{camera, &expected};
    const double limit_chi2 = sharp_only_ ? kCertainChi2 : kJoinChi2;
    const double radius = expected.reach_px(table_.gate_px(camera), limit_chi2);
    sight.first = static_cast<std::uint32_t>(candidates_.size());
    table_.near(camera, expected.pixel, radius, [&](std::uint32_t blob) {
      const Eigen::Vector2d off = table_[blob].pixel - expected.pixel;
      if (off.dot(expected.with(table_[blob]).inverse() * off) <= limit_chi2) candidates_.push_back(blob);
    });
    sight.count = static_cast<std::uint32_t>(candidates_.size()) - sight.first;
    if (sight.count == 0) continue;
    std::size_t around = 0;
    table_.near(camera, expected.pixel, kAround_px, [&around](std::uint32_t) { ++around; });
    sight.log_clutter = std::max(
        log_clutter_[camera],
        std::log(kOthersShare * static_cast<double>(around) / (std::numbers::pi * kAround_px * kAround_px)));
    if (sight.count > kVagueBlobs || radius > kVaguePx) return false;
    sights_.push_back(sight);
  }
  return true;
}

void Claims::count_wishes() {
  wishes_.assign(table_.size(), 0);
  for (const std::uint32_t blob : candidates_) ++wishes_[blob];
  for (Sight& sight : sights_)
    for (std::uint32_t k = sight.first; k < sight.first + sight.count; ++k)
      sight.contested = sight.contested || wishes_[candidates_[k]] > 1;
}

void Claims::search(std::uint32_t number, const Prediction& prediction, std::span<Sight> sights) {
  if (sights.empty()) return;
  // Cameras that leave no choice come first: they narrow the gates of the others.
  std::sort(sights.begin(), sights.end(), [](const Sight& a, const Sight& b) {
    const std::uint32_t p = a.count + (a.contested ? kVagueBlobs : 0),
                        q = b.count + (b.contested ? kVagueBlobs : 0);
    return p != q ? p < q : a.camera < b.camera;
  });
  // A view that is wrong keeps the right ones out, where it seemed too certain to be left out.
  if (!grow_beam(prediction, sights, Skip::IfDoubtful)) grow_beam(prediction, sights, Skip::Always);
  for (const Partial& partial : beam_) {
    if (partial.tuple.count < least_views_) continue;
    Claim& claim = claims_.emplace_back();
    claim.prediction = number;
    claim.tuple = partial.tuple;
    claim.point.position_in_world = prediction.position_in_world + partial.move;
    if (!evaluate(prediction, sights, claim)) claims_.pop_back();
  }
}

bool Claims::grow_beam(const Prediction& prediction, std::span<const Sight> sights, Skip skip) {
  beam_.clear();
  beam_.push_back({Eigen::Vector3d::Zero(), prediction.covariance_m2, 0.0, {}});
  bool agreed = true;
  for (const Sight& sight : sights) {
    grown_.clear();
    for (const Partial& partial : beam_) agreed = extend(sight, partial, skip) && agreed;
    if (grown_.size() > kBeam) {
      std::partial_sort(grown_.begin(), grown_.begin() + kBeam, grown_.end(),
                        [](const Partial& a, const Partial& b) { return a.score > b.score; });
      grown_.resize(kBeam);
    }
    beam_.swap(grown_);
  }
  return agreed;
}

// Whether any of the camera's blobs fits what was chosen before.
bool Claims::extend(const Sight& sight, const Partial& partial, Skip skip) {
  const ExpectedView& expected = *sight.expected;
  const Eigen::Vector2d pixel = expected.pixel + expected.by_position * partial.move;
  const Eigen::Matrix<double, 3, 2> pj = partial.covariance * expected.by_position.transpose();
  Eigen::Matrix2d spread = expected.by_position * pj;
  spread.diagonal().array() += expected.beyond_calibration_px2;
  double nearest = std::numeric_limits<double>::infinity();
  std::size_t joined = 0;
  for (std::uint32_t k = sight.first; k < sight.first + sight.count; ++k) {
    const MatchBlob& blob = table_[candidates_[k]];
    const Eigen::Matrix2d s = spread + blob.covariance_px2;
    const Eigen::Matrix2d s_inverse = s.inverse();
    const Eigen::Vector2d innovation = blob.pixel - pixel;
    const double chi2 = innovation.dot(s_inverse * innovation);
    if (!(chi2 <= kJoinChi2)) continue;
    Partial& next = grown_.emplace_back(partial);
    next.tuple.add(candidates_[k]);
    const Eigen::Matrix<double, 3, 2> gain = pj * s_inverse;
    next.move += gain * innovation;
    next.covariance -= gain * pj.transpose();
    next.score += std::log(kDetected / (1.0 - kDetected)) - sight.log_clutter - log_2pi() -
                  0.5 * std::log(s.determinant()) - 0.5 * chi2;
    nearest = std::min(nearest, chi2);
    ++joined;
  }
  if (skip == Skip::Always || joined != 1 || nearest > kCertainChi2 || sight.contested)
    grown_.push_back(partial);
  return joined > 0;
}

// Fits the views; while they disagree with each other, the one goes whose removal takes most of the
// disagreement away.
bool Claims::evaluate(const Prediction& prediction, std::span<const Sight> sights,
                      Claim& claim) const noexcept {
  const TriangulateOptions fit{options_.marker_radius_m, 0.02};
  const PositionPrior prior{prediction.position_in_world, prediction.covariance_m2};
  std::array<Observation, kMatchCameras> views;
  for (std::uint32_t k = 0; k < claim.tuple.count; ++k)
    views[k] = observation(prediction, claim.tuple.blobs[k]);
  bool sizes_checked = false, completed = false, with_prior = false;
  for (;;) {
    const std::span<const Observation> used(views.data(), claim.tuple.count);
    const bool alone = !with_prior && used.size() >= 2 && rays_fix_position(used, fit.min_angle_rad);
    const auto fitted = refine_point(used, fit, claim.point.position_in_world, alone ? nullptr : &prior);
    if (!fitted) return false;
    claim.point = *fitted;
    const auto views_used = static_cast<unsigned>(used.size());
    bool within = claim.point.chi2 <= point_chi2_limit(alone ? 2 * views_used - 3 : 2 * views_used);
    std::uint32_t worst = 0;
    double worst_statistic = -1.0;
    for (std::uint32_t k = 0; k < used.size(); ++k) {
      const Eigen::Vector2d r =
          reprojection_residual_px(used[k], claim.point.position_in_world, options_.marker_radius_m);
      // What is known to be bad may lie off by as much as it says.
      const double gate2 = std::max(std::pow(table_.gate_px(table_[claim.tuple.blobs[k]].camera), 2),
                                    kJoinChi2 * used[k].covariance_px2.trace());
      within = within && r.squaredNorm() < gate2;
      Eigen::Vector2d pixel;
      Eigen::Matrix<double, 2, 3> j;
      if (!project_pinhole(*used[k].camera, claim.point.position_in_world, pixel, j)) return false;
      const Eigen::Matrix2d left =
          (1.0 + 1e-9) * used[k].covariance_px2 - j * claim.point.covariance_m2 * j.transpose();
      const double statistic = r.dot(left.inverse() * r);
      if (statistic > worst_statistic) {
        worst_statistic = statistic;
        worst = k;
      }
    }
    if (within) {
      if (!completed && alone) {
        completed = true;
        const std::uint32_t before = claim.tuple.count;
        if (complete(prediction, sights, claim)) {
          for (std::uint32_t k = before; k < claim.tuple.count; ++k)
            views[k] = observation(prediction, claim.tuple.blobs[k]);
          continue;
        }
      }
      if (sizes_checked || claim.tuple.count < 2) break;
      sizes_checked = true;
      if (widen_odd_sizes(cameras_, options_, table_, claim.tuple, claim.point.position_in_world, views) == 0)
        break;
      continue;
    }
    if (claim.tuple.count <= least_views_) return false;
    if (claim.tuple.count == 2 && alone) {
      with_prior = true;  // of two that disagree, only the prediction can tell which is wrong
      continue;
    }
    for (std::uint32_t k = worst; k + 1 < claim.tuple.count; ++k) {
      claim.tuple.blobs[k] = claim.tuple.blobs[k + 1];
      views[k] = views[k + 1];
    }
    --claim.tuple.count;
  }
  for (const std::uint32_t blob : claim.tuple.span()) {
    const double range =
        (claim.point.position_in_world - cameras_[table_[blob].camera].position_in_world()).norm();
    if (range < options_.min_range_m || range > options_.max_range_m) return false;
  }
  claim.score = score_of(prediction, sights, claim, {views.data(), claim.tuple.count});
  return std::isfinite(claim.score) && !(claim.tuple.count == 2 && better_alone(prediction, sights, claim));
}

// Two rays nearly always meet somewhere on the way: where that is not where the track expects its marker, it
// is likelier that one of the blobs is another marker's.
bool Claims::better_alone(const Prediction& prediction, std::span<const Sight> sights,
                          const Claim& claim) const noexcept {
  const TriangulateOptions fit{options_.marker_radius_m, 0.02};
  const PositionPrior prior{prediction.position_in_world, prediction.covariance_m2};
  for (const std::uint32_t blob : claim.tuple.span()) {
    const Observation view = observation(prediction, blob);
    Claim alone;
    alone.tuple.add(blob);
    const auto fitted = refine_point({&view, 1}, fit, prediction.position_in_world, &prior);
    if (!fitted) continue;
    alone.point = *fitted;
    if (score_of(prediction, sights, alone, {&view, 1}) > claim.score) return true;
  }
  return false;
}

// The views that met say better than the prediction where the marker is: cameras in which it lay outside of
// the gate may show it, too. Only with blobs that no other track could want.
bool Claims::complete(const Prediction& prediction, std::span<const Sight> sights,
                      Claim& claim) const noexcept {
  std::uint32_t has = 0;
  for (const std::uint32_t blob : claim.tuple.span()) has |= std::uint32_t{1} << table_[blob].camera;
  const std::uint32_t before = claim.tuple.count;
  for (std::uint32_t camera = 0; camera < cameras_.size(); ++camera) {
    if ((has >> camera & 1u) != 0 || table_.grid(camera).empty()) continue;
    const ExpectedView expected =
        expected_.at(prediction, camera, claim.point.position_in_world, claim.point.covariance_m2);
    if (!expected.in_front) continue;
    const auto own =
        std::find_if(sights.begin(), sights.end(), [&](const Sight& s) { return s.camera == camera; });
    std::uint32_t found = 0;
    double nearest = kJoinChi2;
    const double radius = expected.reach_px(table_.gate_px(camera), kJoinChi2);
    table_.near(camera, expected.pixel, std::min(radius, kVaguePx), [&](std::uint32_t blob) {
      bool mine = false;
      for (std::uint32_t k = 0; own != sights.end() && k < own->count; ++k)
        mine = mine || candidates_[own->first + k] == blob;
      if (wishes_[blob] > (mine ? 1u : 0u)) return;
      const Eigen::Vector2d off = table_[blob].pixel - expected.pixel;
      const double chi2 = off.dot(expected.with(table_[blob]).inverse() * off);
      if (chi2 > nearest) return;
      nearest = chi2;
      found = blob + 1;
    });
    if (found != 0) claim.tuple.add(found - 1);
  }
  return claim.tuple.count > before;
}

// Log-likelihood ratio as in Hypotheses, but the position is integrated over the modes of the prediction, and
// the yardstick is that no camera saw the marker.
double Claims::score_of(const Prediction& prediction, std::span<const Sight> sights, const Claim& claim,
                        std::span<const Observation> views) const noexcept {
  double score = 0.0, squares = 0.0;
  for (std::size_t k = 0; k < views.size(); ++k) {
    const std::uint32_t camera = table_[claim.tuple.blobs[k]].camera;
    const auto sight =
        std::find_if(sights.begin(), sights.end(), [camera](const Sight& t) { return t.camera == camera; });
    const double log_clutter = sight == sights.end() ? log_clutter_[camera] : sight->log_clutter;
    score += std::log(kDetected / (1.0 - kDetected)) - log_clutter - log_2pi() -
             0.5 * std::log(views[k].covariance_px2.determinant());
    const Eigen::Vector2d r =
        reprojection_residual_px(views[k], claim.point.position_in_world, options_.marker_radius_m);
    squares += r.dot(views[k].covariance_px2.inverse() * r);
  }
  PredictedMode single;
  double expected = 0.0, nearest = std::numeric_limits<double>::infinity();
  const bool few = views.size() < 3 && cameras_.size() >= 3;
  for (const PredictedMode& mode : modes_of(prediction, single)) {
    if (few && mode.erratic) continue;
    const Eigen::Matrix3d prior = mode.covariance_m2.inverse();
    const Eigen::Matrix3d posterior = (prior + claim.point.information_per_m2).inverse();
    const Eigen::Vector3d away = mode.position_in_world - claim.point.position_in_world, pull = prior * away;
    const Eigen::Vector3d sum = claim.point.gradient_per_m + pull;
    const double distance2 = std::max(0.0, away.dot(pull) - sum.dot(posterior * sum));
    nearest = std::min(nearest, distance2);
    expected += mode.weight * std::exp(-0.5 * distance2) *
                std::sqrt(posterior.determinant() / mode.covariance_m2.determinant());
  }
  if (!(nearest <= kPredictionChi2)) return -std::numeric_limits<double>::infinity();
  return score - 0.5 * squares + std::log(expected);
}

}  // namespace glint
