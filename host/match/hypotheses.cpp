// SPDX-License-Identifier: MIT
// Fitting, checking and scoring tuples of blobs.
#include "host/match/hypotheses.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include <Eigen/LU>

#include "host/match/limits.hpp"
#include "host/match/odd_sizes.hpp"
#include "host/match/visible_volume.hpp"

namespace glint {
namespace {

constexpr std::uint32_t kNone = 0xffffffffu;
// Two views that no third could confirm: so much likelier than a meeting by chance.
constexpr double kCertainLog = 6.9;
constexpr double kTellsSize_px = 1.2;  // more than four pixels, since blocks of two by two may blink
constexpr double kNearlyLog = 10.0, kAnyScore = -1e300;
constexpr std::uint32_t kContestedOneByOne = 4;
constexpr double kEdgeMargin_px = 1.0;  // nearer to the border a marker may well be missed

double log_2pi() noexcept { return std::log(2.0 * std::numbers::pi); }

}  // namespace

Hypotheses::Hypotheses(std::span<const Camera> cameras, const MatchOptions& options, const BlobTable& table)
    : cameras_(cameras), options_(options), table_(table), log_clutter_(cameras.size(), 0.0) {
  triangulate_options_.marker_radius_m = options.marker_radius_m;
  log_volume_ = std::log(visible_volume_m3(cameras, options.min_range_m, options.max_range_m));
}

void Hypotheses::reset(unsigned min_views, std::size_t limit) {
  hypotheses_.clear();
  members_.clear();
  owner_.clear();
  next_of_blob_.clear();
  head_of_blob_.assign(table_.size(), kNone);
  seen_.clear();
  cut_ = held_back_ = 0;
  min_views_ = min_views;
  limit_ = limit;
  full_ = false;
  double blobs = 0.0;
  for (std::size_t camera = 0; camera < cameras_.size(); ++camera) {
    const CameraCalibration& c = cameras_[camera].calibration();
    const double area = std::max(1.0, static_cast<double>(c.width_px) * static_cast<double>(c.height_px));
    const double here = std::max(1.0, static_cast<double>(table_.free_blobs(camera)));
    log_clutter_[camera] = std::log(kClutterShare * here / area);
    blobs += here;
  }
  log_density_ = std::log(blobs / static_cast<double>(cameras_.size())) - log_volume_;
}

bool Hypotheses::already_together(std::uint32_t a, std::uint32_t b) const noexcept {
  for (std::uint32_t m = head_of_blob_[a]; m != kNone; m = next_of_blob_[m]) {
    const Hypothesis& h = hypotheses_[owner_[m]];
    if (h.count < 3) continue;
    const auto blobs = blobs_of(h);
    if (std::find(blobs.begin(), blobs.end(), b) != blobs.end()) return true;
  }
  return false;
}

void Hypotheses::consider(BlobTuple tuple) {
  const auto hash_of = [](BlobTuple& t) {
    std::sort(t.blobs.begin(), t.blobs.begin() + t.count);
    std::uint64_t hash = 0;
    for (std::uint32_t blob : t.span()) hash += scramble(blob);
    return hash;
  };
  const std::uint64_t hash = hash_of(tuple);
  if (!seen_.insert(hash)) return;
  Hypothesis h;
  if (!evaluate(tuple, h)) return;
  const std::uint64_t reduced = hash_of(tuple);
  if (reduced != hash && !seen_.insert(reduced)) return;
  if (h.doubtful && tuple.count == 2) {
    ++held_back_;
    return;
  }
  if (hypotheses_.size() >= limit_) {
    full_ = true;
    ++cut_;
    return;
  }
  h.first = static_cast<std::uint32_t>(members_.size());
  h.count = tuple.count;
  for (std::uint32_t blob : tuple.span()) {
    owner_.push_back(static_cast<std::uint32_t>(hypotheses_.size()));
    next_of_blob_.push_back(head_of_blob_[blob]);
    head_of_blob_[blob] = static_cast<std::uint32_t>(members_.size());
    members_.push_back(blob);
  }
  hypotheses_.push_back(h);
}

// Fits all views; while they disagree, the view goes whose removal takes most of the disagreement away (its
// deletion statistic r' (R - J P J')^-1 r; Cook and Weisberg, Residuals and Influence in Regression, 1982).
bool Hypotheses::fit(BlobTuple& tuple, std::array<Observation, kMatchCameras>& views,
                     Triangulated& point) const noexcept {
  for (;;) {
    const std::span<const Observation> used(views.data(), tuple.count);
    const auto fitted = triangulate(used, triangulate_options_);
    if (!fitted) return false;
    point = *fitted;
    std::size_t worst = 0;
    double worst_statistic = -1.0;
    bool within = point.chi2 <= point_chi2_limit(2 * tuple.count - 3);
    for (std::size_t k = 0; k < used.size(); ++k) {
      const Eigen::Vector2d r =
          reprojection_residual_px(used[k], point.position_in_world, options_.marker_radius_m);
      within = within && r.norm() < table_.gate_px(table_[tuple.blobs[k]].camera);
      Eigen::Vector2d pixel;
      Eigen::Matrix<double, 2, 3> j;
      if (!project_pinhole(*used[k].camera, point.position_in_world, pixel, j)) return false;
      // A trace of R keeps it invertible where one view alone fixes a direction (two views).
      const Eigen::Matrix2d left =
          (1.0 + 1e-9) * used[k].covariance_px2 - j * point.covariance_m2 * j.transpose();
      const double statistic = r.dot(left.inverse() * r);
      if (statistic > worst_statistic) {
        worst_statistic = statistic;
        worst = k;
      }
    }
    if (within) return true;
    if (tuple.count <= std::max(min_views_, 2u)) return false;
    for (std::size_t k = worst; k + 1 < tuple.count; ++k) {
      tuple.blobs[k] = tuple.blobs[k + 1];
      views[k] = views[k + 1];
    }
    --tuple.count;
  }
}

bool Hypotheses::evaluate(BlobTuple& tuple, Hypothesis& h) const noexcept {
  std::array<Observation, kMatchCameras> views;
  for (std::size_t k = 0; k < tuple.count; ++k) {
    const MatchBlob& blob = table_[tuple.blobs[k]];
    views[k] = {&cameras_[blob.camera], blob.normalized, blob.covariance_px2};
  }
  if (!fit(tuple, views, h.point)) return false;
  const std::uint32_t odd =
      widen_odd_sizes(cameras_, options_, table_, tuple, h.point.position_in_world, views);
  if (odd != 0 && !fit(tuple, views, h.point)) return false;
  unsigned good = 0;
  for (std::uint32_t blob : tuple.span()) {
    if (!table_[blob].suspect && (odd >> table_[blob].camera & 1u) == 0) ++good;
    const double range =
        (h.point.position_in_world - cameras_[table_[blob].camera].position_in_world()).norm();
    if (range < options_.min_range_m || range > options_.max_range_m) return false;
  }
  h.doubtful = good < 2;
  h.complete = good == tuple.count &&
               std::all_of(tuple.span().begin(), tuple.span().end(),
                           [this](std::uint32_t blob) { return table_[blob].radius_px > kTellsSize_px; });
  const std::span<const Observation> used(views.data(), tuple.count);
  h.score = score_of(tuple, used, h);
  return std::isfinite(h.score);
}

// Log-likelihood ratio as in multi-sensor assignment (Poore 1994; Deb, Yeddanapudi, Pattipati, Bar-Shalom
// 1997): each blob is worth its density at the residual over that of clutter, each camera that should see the
// marker and does not costs log(1 - P_D), and the position is integrated over its prior: as many markers as a
// camera has blobs, uniformly in the volume.
double Hypotheses::score_of(const BlobTuple& tuple, std::span<const Observation> views,
                            Hypothesis& h) const noexcept {
  double score = -0.5 * h.point.chi2;
  std::uint32_t seen_by = 0;
  for (std::size_t k = 0; k < views.size(); ++k) {
    const std::uint32_t camera = table_[tuple.blobs[k]].camera;
    seen_by |= 1u << camera;
    score += std::log(kDetected) - log_clutter_[camera] - log_2pi() -
             0.5 * std::log(views[k].covariance_px2.determinant());
  }
  for (std::size_t camera = 0; camera < cameras_.size(); ++camera)
    if ((seen_by >> camera & 1u) == 0 && sees(cameras_[camera], h.point.position_in_world, kEdgeMargin_px,
                                              options_.min_range_m, options_.max_range_m)) {
      score += std::log(1.0 - kDetected);
      h.complete = false;
    }
  score += 0.5 * std::log(h.point.covariance_m2.determinant());
  return score + 1.5 * log_2pi() + log_density_;
}

// A variant of the same marker shares most blobs with it; another marker does not.
bool Hypotheses::shared_by_others(std::uint32_t blob, std::size_t hypothesis,
                                  double least_score) const noexcept {
  const Hypothesis& h = hypotheses_[hypothesis];
  for (std::uint32_t m = head_of_blob_[blob]; m != kNone; m = next_of_blob_[m]) {
    const Hypothesis& other = hypotheses_[owner_[m]];
    if (owner_[m] == hypothesis || other.score < least_score) continue;
    const auto a = blobs_of(h), b = blobs_of(other);  // both ascending
    std::size_t common = 0;
    for (std::size_t i = 0, j = 0; i < a.size() && j < b.size();) {
      if (a[i] == b[j]) ++common;
      if (a[i] < b[j]) {
        ++i;
      } else {
        ++j;
      }
    }
    if (2 * common <= a.size()) return true;
  }
  return false;
}

bool Hypotheses::certain(std::size_t hypothesis) const noexcept {
  const Hypothesis& h = hypotheses_[hypothesis];
  if (h.count < 3 && !(h.complete && h.score > kCertainLog)) return false;
  const auto blobs = blobs_of(h);
  const double nearly = h.score - kNearlyLog;
  return std::none_of(blobs.begin(), blobs.end(),
                      [&](std::uint32_t blob) { return shared_by_others(blob, hypothesis, nearly); });
}

void Hypotheses::split_contested() {
  const std::size_t originals = hypotheses_.size();
  for (std::size_t k = 0; k < originals; ++k) {
    const Hypothesis h = hypotheses_[k];
    if (h.count <= std::max(min_views_, 2u)) continue;
    BlobTuple contested, rest;
    for (std::uint32_t m = 0; m < h.count; ++m) {
      const std::uint32_t blob = members_[h.first + m];
      (shared_by_others(blob, k, kAnyScore) ? contested : rest).add(blob);
    }
    if (contested.count == 0) continue;
    if (rest.count >= min_views_) consider(rest);
    // One by one only while they are few: of many, it is rarely just one that the other marker takes.
    if (contested.count == 1 || contested.count > kContestedOneByOne) continue;
    for (std::uint32_t left_out : contested.span()) {
      BlobTuple without;
      for (std::uint32_t m = 0; m < h.count; ++m)
        if (members_[h.first + m] != left_out) without.add(members_[h.first + m]);
      consider(without);
    }
  }
}

}  // namespace glint
