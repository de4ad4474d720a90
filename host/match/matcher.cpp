// SPDX-License-Identifier: MIT
// The stages of matching: what tracks expect, then points of three or more views, then of two.
#include "host/match/matcher.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>

#include "host/base/check.hpp"
#include "host/base/error.hpp"
#include "host/geometry/floor_point.hpp"
#include "host/match/blob_table.hpp"
#include "host/match/hypotheses.hpp"
#include "host/match/limits.hpp"
#include "host/match/pair_search.hpp"
#include "host/match/set_packing.hpp"

namespace glint {
namespace {

// A prediction that is this uncertain in some camera, or that finds so many blobs, cannot tell them apart:
// its marker is found without it, and the tracker joins them.
constexpr double kVaguePx = 40.0;
constexpr std::size_t kVagueBlobs = 6;

// Tuples kept at most: 150 MB. Far fewer (so many per blob of the fullest camera, and some) mean that the
// blobs are too dense for so few views to tell them apart; then more views are asked for first.
constexpr std::size_t kMaxHypotheses = std::size_t{1} << 19;
constexpr std::size_t kAmbiguousPerBlob = 8, kAmbiguousBase = 4096;

void check_plane(const Calibration& calibration, double height_m) {
  if (calibration.cameras.size() != 1) {
    throw Error("match.plane_height_m is for a rig of one camera, and this one has " +
                std::to_string(calibration.cameras.size()) +
                ": leave it out, several cameras measure heights themselves");
  }
  const CameraCalibration& camera = calibration.cameras.front();
  char plane[32];
  std::snprintf(plane, sizeof plane, "z = %g m", height_m);
  switch (sight_of_plane(Camera(camera), height_m)) {
    case PlaneSight::Seen:
      return;
    case PlaneSight::Behind:
      throw Error(
          "camera " + camera.name + " does not look at the plane " + plane +
          " anywhere in its image: check match.plane_height_m and where the calibration says it stands");
    case PlaneSight::EdgeOn:
      throw Error("camera " + camera.name + " sees the plane " + plane +
                  " only edge-on, at less than 5 degrees: it must look down on the markers; check "
                  "match.plane_height_m");
  }
}

std::vector<Camera> make_cameras(const Calibration& calibration) {
  if (calibration.cameras.size() > kMatchCameras)
    throw Error("the calibration has " + std::to_string(calibration.cameras.size()) +
                " cameras; at most 32 can be matched");
  return {calibration.cameras.begin(), calibration.cameras.end()};
}

}  // namespace

struct Matcher::Impl {
  Impl(const Calibration& calibration, const MatchOptions& given)
      : options(given),
        cameras(make_cameras(calibration)),
        table(cameras, options),
        pairs(cameras, options, table),
        hypotheses(cameras, options, table) {}

  void meet_plane();
  void match_predictions(std::span<const Prediction> predictions);
  void collect_candidates(const Prediction& prediction);
  void match_all_pairs(unsigned min_views);
  bool collect_all_pairs(unsigned min_views, std::size_t limit);
  void suspect_what_points_explain();
  void select(double bonus, std::size_t prediction_count);
  void accept(const Hypothesis& h);

  const MatchOptions options;
  const std::vector<Camera> cameras;
  BlobTable table;
  PairSearch pairs;
  Hypotheses hypotheses;
  SetPacking packing;
  SetPacking::Counters packed;
  std::vector<std::uint32_t> chosen, elements;
  std::vector<std::vector<std::uint32_t>> candidates;  // by camera, of one prediction
  bool vague = false;

  std::span<const Prediction> predictions;
  std::vector<Point>* points = nullptr;
  MatchCounters* counters = nullptr;
};

Matcher::Matcher(const Calibration& calibration, const MatchOptions& options) {
  std::vector<std::string> problems;
  options.check(problems);
  if (!problems.empty()) throw Error(problems.front());
  if (options.plane_height_m) check_plane(calibration, *options.plane_height_m);
  impl_ = std::make_unique<Impl>(calibration, options);
}

Matcher::~Matcher() = default;

void Matcher::match(std::span<const std::span<const shaders::BlobRecord>> blobs,
                    std::span<const Prediction> predictions, std::vector<Point>& points,
                    MatchCounters& counters) {
  Impl& m = *impl_;
  GLINT_CHECK(blobs.size() == m.cameras.size());
  points.clear();
  m.points = &points;
  m.counters = &counters;
  m.predictions = predictions;
  m.packed = {};
  m.candidates.resize(m.cameras.size());
  m.table.fill(blobs);
  counters.blobs += m.table.size();

  if (m.options.plane_height_m) {
    m.meet_plane();
  } else {
    if (!predictions.empty()) m.match_predictions(predictions);
    m.match_all_pairs(std::max(3u, m.options.min_cameras));
    if (m.options.min_cameras == 2) {
      m.suspect_what_points_explain();
      m.match_all_pairs(2);
    }
  }

  std::uint64_t used = 0;
  for (const Point& point : points) used += point.views;
  counters.points += points.size();
  counters.unmatched_blobs += m.table.size() - used;
  counters.components += m.packed.components;
  counters.exact += m.packed.exact;
  counters.inexact += m.packed.inexact;
}

// One camera: each blob's ray where it meets the plane that the markers are on.
void Matcher::Impl::meet_plane() {
  const Camera& camera = cameras.front();
  for (std::uint32_t blob = table.begin_of(0); blob < table.end_of(0); ++blob) {
    if (!table.free(blob)) continue;
    const auto met = floor_point({&camera, table[blob].normalized, table[blob].covariance_px2},
                                 *options.plane_height_m, options.marker_radius_m);
    if (!met) continue;
    const double range_m = (met->position_in_world - camera.position_in_world()).norm();
    if (range_m < options.min_range_m || range_m > options.max_range_m) continue;
    Point& point = points->emplace_back();
    point.position_in_world = met->position_in_world;
    point.covariance_m2 = met->covariance_m2;
    point.views = 1;
    point.blob_of_camera.fill(-1);
    point.blob_of_camera[0] = static_cast<std::int32_t>(blob);
    table.claim(blob);
  }
}

// Blobs near to where the prediction expects them, by camera; sets `vague` if there are too many to be of
// use.
void Matcher::Impl::collect_candidates(const Prediction& prediction) {
  vague = false;
  for (std::size_t camera = 0; camera < cameras.size(); ++camera) {
    auto& list = candidates[camera];
    list.clear();
    Eigen::Vector2d pixel;
    Eigen::Matrix<double, 2, 3> jacobian;
    if (!project_pinhole(cameras[camera], prediction.position_in_world, pixel, jacobian)) continue;
    const Eigen::Matrix2d spread = jacobian * prediction.covariance_m2 * jacobian.transpose();
    const double radius = options.gate_px + std::sqrt(kPredictionChi2 * spread.trace());
    table.near(camera, pixel, radius, [&](std::uint32_t blob) { list.push_back(blob); });
    vague = vague || list.size() > kVagueBlobs || (radius > kVaguePx && !list.empty());
  }
}

void Matcher::Impl::match_predictions(std::span<const Prediction> all) {
  hypotheses.reset(all, options.min_cameras, kMaxHypotheses);
  for (std::uint32_t k = 0; k < all.size(); ++k) {
    if (!all[k].position_in_world.allFinite() || !all[k].covariance_m2.allFinite()) continue;
    collect_candidates(all[k]);
    if (vague) continue;
    for (std::size_t a = 0; a < cameras.size(); ++a)
      for (std::size_t b = a + 1; b < cameras.size(); ++b)
        for (std::uint32_t p : candidates[a])
          for (std::uint32_t q : candidates[b])
            if (const auto pair = pairs.meet(p, q)) hypotheses.grow(*pair, k);
  }
  hypotheses.split_contested();
  select(0.0, all.size());
}

void Matcher::Impl::match_all_pairs(unsigned min_views) {
  if (cameras.size() < min_views) return;
  std::size_t fullest = 0;
  for (std::size_t camera = 0; camera < cameras.size(); ++camera)
    fullest = std::max(fullest, table.free_blobs(camera));
  const std::size_t limit = std::min(kMaxHypotheses, kAmbiguousBase + kAmbiguousPerBlob * fullest);
  if (!collect_all_pairs(min_views, limit)) {
    // Too dense: first what one view more confirms, then this with what is left.
    if (min_views < cameras.size()) match_all_pairs(min_views + 1);
    collect_all_pairs(min_views, kMaxHypotheses);
  }
  hypotheses.split_contested();
  select(min_views == 2 ? -kTwoViewLogOdds : 0.0, 0);
}

// False if there are more than `limit` hypotheses: the rest was not looked for unless the limit is the last
// one.
bool Matcher::Impl::collect_all_pairs(unsigned min_views, std::size_t limit) {
  hypotheses.reset({}, min_views, limit);
  for (std::size_t a = 0; a < cameras.size(); ++a)
    for (std::uint32_t blob = table.begin_of(a); blob < table.end_of(a); ++blob) {
      if (!table.free(blob)) continue;
      for (std::size_t b = a + 1; b < cameras.size(); ++b)
        pairs.partners(blob, b, [&](const BlobPair& pair) { hypotheses.grow(pair, kNoPrediction); });
      if (hypotheses.full() && limit < kMaxHypotheses) return false;
    }
  return !hypotheses.full();
}

// A camera that should show a point but has no blob for it may show it merged into another blob nearby, which
// then is a bad witness for any further point.
void Matcher::Impl::suspect_what_points_explain() {
  for (const Point& point : *points) {
    double radius_m = 0.0;
    for (std::size_t camera = 0; camera < cameras.size(); ++camera) {
      if (point.blob_of_camera[camera] < 0) continue;
      const MatchBlob& blob =
          table[table.begin_of(camera) + static_cast<std::uint32_t>(point.blob_of_camera[camera])];
      const double range = (point.position_in_world - cameras[camera].position_in_world()).norm();
      radius_m = std::max(radius_m, blob.radius_px * blob.angle_per_px * range);
    }
    for (std::size_t camera = 0; camera < cameras.size(); ++camera) {
      if (point.blob_of_camera[camera] >= 0) continue;
      Eigen::Vector2d pixel;
      Eigen::Matrix<double, 2, 3> jacobian;
      if (!project_pinhole(cameras[camera], point.position_in_world, pixel, jacobian)) continue;
      const double own_px = radius_m * jacobian.row(0).norm();
      // A merged blob is at most about twice as wide as one marker.
      table.near(camera, pixel, std::max(options.gate_px, 3.0 * own_px), [&](std::uint32_t blob) {
        const double reach = std::max(options.gate_px, own_px + table[blob].radius_px);
        if ((table[blob].pixel - pixel).norm() < reach) table.suspect(blob);
      });
    }
  }
}

void Matcher::Impl::select(double bonus, std::size_t prediction_count) {
  packing.reset(table.size() + prediction_count);
  for (std::size_t k = 0; k < hypotheses.size(); ++k) {
    const Hypothesis& h = hypotheses[k];
    elements.assign(hypotheses.blobs_of(h).begin(), hypotheses.blobs_of(h).end());
    if (h.prediction != kNoPrediction)
      elements.push_back(static_cast<std::uint32_t>(table.size() + h.prediction));
    packing.add(elements, h.score + bonus);
  }
  packing.solve(chosen, packed);
  std::sort(chosen.begin(), chosen.end());
  for (std::uint32_t k : chosen) accept(hypotheses[k]);
  counters->hypotheses += hypotheses.size();
  counters->hypotheses_cut += hypotheses.cut();
  counters->held_back += hypotheses.held_back();
}

void Matcher::Impl::accept(const Hypothesis& h) {
  Point& point = points->emplace_back();
  point.position_in_world = h.point.position_in_world;
  point.covariance_m2 = h.point.covariance_m2;
  point.rms_px = h.point.rms_px;
  point.views = h.count;
  point.blob_of_camera.fill(-1);
  if (h.prediction != kNoPrediction) point.predicted_by = predictions[h.prediction].track;
  for (std::uint32_t blob : hypotheses.blobs_of(h)) {
    const std::uint32_t camera = table[blob].camera;
    point.blob_of_camera[camera] = static_cast<std::int32_t>(blob - table.begin_of(camera));
    table.claim(blob);
  }
}

}  // namespace glint
