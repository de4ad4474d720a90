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
#include "host/match/claims.hpp"
#include "host/match/expected_views.hpp"
#include "host/match/hypotheses.hpp"
#include "host/match/limits.hpp"
#include "host/match/pair_search.hpp"
#include "host/match/pixel_look.hpp"
#include "host/match/set_packing.hpp"

namespace glint {
namespace {

// Tuples kept at most: 150 MB. Far fewer (so many per blob of the fullest camera, and some) mean that the
// blobs are too dense for so few views to tell them apart; then more views are asked for first.
constexpr std::size_t kMaxHypotheses = std::size_t{1} << 19;
constexpr std::size_t kManyCameras = 8;
constexpr double kAloneChi2 = 1e-6;  // views that alone placed a point are in balance but for rounding
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
        hypotheses(cameras, options, table),
        expected(cameras, options, table),
        claims(cameras, options, table, expected),
        pixels(cameras, options, table, expected) {}

  void meet_plane();
  void match_claims(ClaimViews views);
  enum class Seeds : std::uint8_t { All, Unexplained };
  void match_all_pairs(unsigned min_views, Seeds seeds);
  bool collect_all_pairs(unsigned min_views, Seeds seeds, std::size_t limit);
  void suspect_what_points_explain();
  void select(double bonus);
  bool shows_slivers(std::span<const std::uint32_t> blobs, const Point& point) const noexcept;
  void learn_noise(std::uint32_t blob, const Point& point, const Eigen::Matrix<double, 2, 3>& jacobian,
                   const Prediction& claimed_by);
  Point& accept(std::span<const std::uint32_t> blobs, const Triangulated& found,
                const Prediction* claimed_by = nullptr);

  const MatchOptions options;
  const std::vector<Camera> cameras;
  BlobTable table;
  PairSearch pairs;
  Hypotheses hypotheses;
  ExpectedViews expected;
  Claims claims;
  PixelLook pixels;
  SetPacking packing;
  SetPacking::Counters packed;
  std::vector<std::uint32_t> chosen, elements;
  std::vector<std::uint8_t> settled;  // by prediction: has its blobs

  std::span<const std::span<const shaders::BlobRecord>> records;
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
                    MatchCounters& counters, std::span<const gpu::ImageView> images) {
  Impl& m = *impl_;
  GLINT_CHECK(blobs.size() == m.cameras.size());
  points.clear();
  m.points = &points;
  m.counters = &counters;
  m.predictions = predictions;
  m.records = blobs;
  m.packed = {};
  m.table.fill(blobs);
  counters.blobs += m.table.size();
  m.expected.fill(predictions);
  if (m.options.marker_radius_m > 0.0 && !images.empty()) m.pixels.look(blobs, images, predictions, counters);

  if (m.options.plane_height_m) {
    m.meet_plane();
  } else {
    m.settled.assign(predictions.size(), 0);
    m.match_claims(ClaimViews::Several);
    // What claimed points explain does not start a search where many cameras are left to see a new marker
    // alone.
    const bool many = m.cameras.size() > kManyCameras;
    if (many) m.suspect_what_points_explain();
    m.match_all_pairs(std::max(3u, m.options.min_cameras),
                      many ? Matcher::Impl::Seeds::Unexplained : Matcher::Impl::Seeds::All);
    // Of two cameras every new point has all views that it can have.
    if (m.cameras.size() > 2) m.match_claims(ClaimViews::SharpSingle);
    if (m.options.min_cameras == 2) {
      m.suspect_what_points_explain();
      m.match_all_pairs(2, Matcher::Impl::Seeds::All);
    }
    m.match_claims(ClaimViews::Single);
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
    point.blob_of_camera[0] = static_cast<std::int32_t>(table[blob].record);
    table.claim(blob);
  }
}

// Tracks have the first choice, and with one camera alone the last: what looks like a lone blob of a lost
// track may be part of the point at which it came back. Each blob and each track is used once; all choices
// are weighed together.
void Matcher::Impl::match_claims(ClaimViews views) {
  if (predictions.empty()) return;
  claims.find(predictions, settled, views);
  const std::span<const Claim> all = claims.all();
  packing.reset(table.size() + predictions.size());
  for (const Claim& claim : all) {
    elements.assign(claim.tuple.span().begin(), claim.tuple.span().end());
    elements.push_back(static_cast<std::uint32_t>(table.size() + claim.prediction));
    packing.add(elements, claim.score);
  }
  packing.solve(chosen, packed);
  std::sort(chosen.begin(), chosen.end());
  for (const std::uint32_t k : chosen) {
    accept(all[k].tuple.span(), all[k].point, &predictions[all[k].prediction]);
    settled[all[k].prediction] = 1;
  }
  counters->hypotheses += all.size();
}

void Matcher::Impl::match_all_pairs(unsigned min_views, Seeds seeds) {
  if (cameras.size() < min_views) return;
  std::size_t fullest = 0;
  for (std::size_t camera = 0; camera < cameras.size(); ++camera)
    fullest = std::max(fullest, table.free_blobs(camera));
  const std::size_t limit = std::min(kMaxHypotheses, kAmbiguousBase + kAmbiguousPerBlob * fullest);
  if (!collect_all_pairs(min_views, seeds, limit)) {
    // Too dense: first what one view more confirms, then this with what is left.
    if (min_views < cameras.size()) match_all_pairs(min_views + 1, seeds);
    collect_all_pairs(min_views, seeds, kMaxHypotheses);
  }
  hypotheses.split_contested();
  select(min_views == 2 ? -kTwoViewLogOdds : 0.0);
}

// False if there are more than `limit` hypotheses: the rest was not looked for unless the limit is the last
// one.
bool Matcher::Impl::collect_all_pairs(unsigned min_views, Seeds seeds, std::size_t limit) {
  hypotheses.reset(min_views, limit);
  const auto explained = [&](std::uint32_t blob) {
    return seeds == Seeds::Unexplained && table[blob].suspect;
  };
  for (std::size_t a = 0; a < cameras.size(); ++a)
    for (std::uint32_t blob = table.begin_of(a); blob < table.end_of(a); ++blob) {
      if (!table.free(blob) || explained(blob)) continue;
      for (std::size_t b = a + 1; b < cameras.size(); ++b)
        pairs.partners(blob, b, [&](const BlobPair& pair) {
          if (!explained(pair.b)) hypotheses.grow(pair);
        });
      if (hypotheses.full() && limit < kMaxHypotheses) return false;
    }
  return !hypotheses.full();
}

// A camera that should show a point but has no blob for it may show it merged into another blob nearby, which
// then is a bad witness for any further point.
void Matcher::Impl::suspect_what_points_explain() {
  for (const Point& point : *points) {
    double radius_m = options.marker_radius_m;
    for (std::size_t camera = 0; camera < cameras.size() && options.marker_radius_m <= 0.0; ++camera) {
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
      table.near(camera, pixel, std::max(table.gate_px(camera), 3.0 * own_px), [&](std::uint32_t blob) {
        const double reach = std::max(table.gate_px(camera), own_px + table[blob].radius_px);
        if ((table[blob].pixel - pixel).norm() < reach) table.suspect(blob);
      });
    }
  }
}

void Matcher::Impl::select(double bonus) {
  packing.reset(table.size());
  for (std::size_t k = 0; k < hypotheses.size(); ++k)
    packing.add(hypotheses.blobs_of(hypotheses[k]), hypotheses[k].score + bonus);
  packing.solve(chosen, packed);
  std::sort(chosen.begin(), chosen.end());
  for (const std::uint32_t k : chosen) {
    const std::span<const std::uint32_t> blobs = hypotheses.blobs_of(hypotheses[k]);
    Point& point = accept(blobs, hypotheses[k].point);
    point.doubtful = point.doubtful || shows_slivers(blobs, point);
    point.certain = hypotheses.certain(k) && !point.doubtful;
  }
  counters->hypotheses += hypotheses.size();
  counters->hypotheses_cut += hypotheses.cut();
  counters->held_back += hypotheses.held_back();
}

// What is left of a marker in several cameras may meet as well as all of it would.
bool Matcher::Impl::shows_slivers(std::span<const std::uint32_t> blobs, const Point& point) const noexcept {
  if (!(options.marker_radius_m > 0.0)) return false;
  unsigned whole = 0;
  for (const std::uint32_t blob : blobs) {
    const MatchBlob& b = table[blob];
    if (!b.suspect && pixels.shows_whole(b.camera, records[b.camera][b.record], point.position_in_world))
      ++whole;
  }
  return whole < 2;
}

Point& Matcher::Impl::accept(std::span<const std::uint32_t> blobs, const Triangulated& found,
                             const Prediction* claimed_by) {
  Point& point = points->emplace_back();
  if (claimed_by != nullptr) point.predicted_by = claimed_by->track;
  point.position_in_world = found.position_in_world;
  point.covariance_m2 = found.covariance_m2;
  point.rms_px = found.rms_px;
  point.views = static_cast<std::uint32_t>(blobs.size());
  point.information_per_m2 = found.information_per_m2;
  point.gradient_per_m = found.gradient_per_m;
  point.blob_of_camera.fill(-1);
  unsigned whole = 0;
  Eigen::Matrix3d by_calibration = Eigen::Matrix3d::Zero();
  for (const std::uint32_t blob : blobs) {
    const std::uint32_t camera = table[blob].camera;
    point.blob_of_camera[camera] = static_cast<std::int32_t>(table[blob].record);
    if (!table[blob].suspect) ++whole;
    point.light = std::max(point.light, table[blob].light);
    if (table[blob].resolved) point.resolved |= std::uint32_t{1} << camera;
    table.claim(blob);
    Eigen::Vector2d pixel;
    Eigen::Matrix<double, 2, 3> jacobian;
    if (!project_outline(cameras[camera], point.position_in_world, options.marker_radius_m, pixel, jacobian))
      continue;
    const double calibration_px2 = table.calibration_variance_px2(camera);
    point.residual_px[camera] = (table[blob].pixel - pixel).cast<float>();
    point.noise_px2[camera] = static_cast<float>(0.5 * table[blob].covariance_px2.trace() - calibration_px2);
    if (claimed_by != nullptr) learn_noise(blob, point, jacobian, *claimed_by);
    if (calibration_px2 > 0.0) by_calibration += jacobian.transpose() * jacobian / calibration_px2;
  }
  point.doubtful = whole < 2;
  point.calibration_covariance_m2.setZero();
  if (point.views >= 2 && by_calibration.trace() > 0.0) {
    // Where two cameras face each other, their calibration alone bounds little; a metre is as good as
    // nothing.
    point.calibration_covariance_m2 = (by_calibration + Eigen::Matrix3d::Identity()).inverse();
  }
  return point;
}

// From tracks, of which it is known by how much the calibration errs where they are.
void Matcher::Impl::learn_noise(std::uint32_t blob, const Point& point,
                                const Eigen::Matrix<double, 2, 3>& jacobian, const Prediction& claimed_by) {
  const MatchBlob& b = table[blob];
  // What was placed by the prediction, too, has other residuals.
  if (b.suspect || point.views < 2 ||
      point.gradient_per_m.dot(point.covariance_m2 * point.gradient_per_m) > kAloneChi2)
    return;
  const ViewBias bias = b.camera < claimed_by.bias.size() ? claimed_by.bias[b.camera] : ViewBias{};
  const double given_px2 = options.sigma_px * options.sigma_px;
  const double own_px2 = static_cast<double>(point.noise_px2[b.camera]) - given_px2;
  // Where the rest is larger, the residual says little of the blob.
  if (!(bias.variance_px2 + given_px2 < own_px2)) return;
  const double decided = (jacobian * point.covariance_m2 * jacobian.transpose()).trace();
  const double freedom = 2.0 - 2.0 * decided / b.covariance_px2.trace();
  const double squared_px2 = (point.residual_px[b.camera].cast<double>() - bias.px).squaredNorm();
  table.learn_noise(blob, (squared_px2 - 2.0 * bias.variance_px2 - freedom * given_px2) / own_px2, freedom);
}

}  // namespace glint
