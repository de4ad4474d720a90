// SPDX-License-Identifier: MIT
// Birth, life and death of tracks.
#include "host/track/tracker.hpp"

#include <algorithm>
#include <cmath>

#include <Eigen/LU>

#include "host/base/error.hpp"
#include "host/track/assignment.hpp"
#include "host/track/motion.hpp"

namespace glint {
namespace {

// Chi-square, three degrees of freedom: 25 is exceeded once in 65,000 by a marker that moves as the model
// says, and such markers are what the gate is for; 11.3 (1 %) is where the velocity is taken to have changed.
constexpr double kGateChi2 = 25.0, kSurpriseChi2 = 11.3;
// Triangulation does not know all of its errors; below this the filter would trust it blindly.
constexpr double kMeasurementFloor_m = 2e-5;
// Points of unknown origin per cubic metre and frame: what an assignment must beat. Only its logarithm
// counts.
constexpr double kNewPointDensity = 0.01;
// A marker bounces off with at most the speed that it came with, give or take.
constexpr double kBounceSpeedFactor = 1.2, kBounceSpeedOffset_m_s = 1.0;
constexpr double kStandStill_m = 0.01;  // how far measurements of a marker at rest may lie apart, generously
constexpr unsigned kBounceFrames = 2;   // frames after the last measurement in which a bounce is looked for

struct Track {
  TrackId id;
  Motion motion;
  Eigen::Vector3d measured_at;  ///< last measured position
  double since_measured_s;
  unsigned seen, missed;
  bool published;
  std::uint32_t point;  ///< of this frame
};

Eigen::Matrix3d measurement_covariance(const Point& point) noexcept {
  return point.covariance_m2 + kMeasurementFloor_m * kMeasurementFloor_m * Eigen::Matrix3d::Identity();
}

}  // namespace

struct Tracker::Impl {
  explicit Impl(const TrackOptions& given) : options(given) {}

  void take_predicted(std::span<const Point> points);
  void assign_by_likelihood(std::span<const Point> points);
  void assign_bounces(std::span<const Point> points);
  void correct(Track& track, const Point& point);
  void start(const Point& point, std::uint32_t number);
  void sort_points(std::span<const Point> points);
  template <typename Visit>
  void free_points_near(std::span<const Point> points, const Eigen::Vector3d& centre, double reach_m,
                        Visit&& visit);

  const TrackOptions options;
  std::vector<Track> tracks;  // ascending ids
  std::uint32_t next_id = 1;
  bool started = false;
  Timestamp now{};
  double step_s = 0.0;

  std::vector<std::uint8_t> point_taken;
  std::vector<std::uint32_t> points_by_x, column_of_row, row_track;
  std::vector<AssignmentEdge> edges;
  std::vector<std::uint32_t> edges_of_point;
  Assignment assignment;
};

Tracker::Tracker(const TrackOptions& options) {
  std::vector<std::string> problems;
  options.check(problems);
  if (!problems.empty()) throw Error(problems.front());
  impl_ = std::make_unique<Impl>(options);
}

Tracker::~Tracker() = default;

void Tracker::predict(Timestamp exposed, std::vector<Prediction>& predictions) {
  Impl& t = *impl_;
  // Exposures that come out of order are no reason to run backwards.
  t.step_s = t.started ? std::max(0.0, seconds_between(t.now, exposed)) : 0.0;
  t.started = true;
  t.now = std::max(t.now, exposed);
  predictions.clear();
  for (Track& track : t.tracks) {
    track.motion.advance(t.step_s, t.options.acceleration_sd_m_s2);
    track.since_measured_s += t.step_s;
    track.point = kUnassigned;
    predictions.push_back({track.id, track.motion.position(), track.motion.position_covariance()});
  }
}

void Tracker::update(std::span<const Point> points, std::vector<TrackedPoint>& tracked,
                     TrackCounters& counters) {
  Impl& t = *impl_;
  tracked.clear();
  t.point_taken.assign(points.size(), 0);
  t.take_predicted(points);
  t.sort_points(points);
  t.assign_by_likelihood(points);
  t.assign_bounces(points);

  for (Track& track : t.tracks) {
    if (track.point == kUnassigned) {
      ++track.missed;
      continue;
    }
    t.correct(track, points[track.point]);
  }
  // A track that was never shown must be seen in every frame; one that was may be hidden for a while.
  const auto ended = std::remove_if(t.tracks.begin(), t.tracks.end(), [&](const Track& track) {
    return track.missed > (track.published ? t.options.max_missed_frames : 0u);
  });
  counters.ended += static_cast<std::uint64_t>(t.tracks.end() - ended);
  t.tracks.erase(ended, t.tracks.end());
  for (std::uint32_t k = 0; k < points.size(); ++k) {
    if (t.point_taken[k] != 0) continue;
    t.start(points[k], k);
    ++counters.started;
  }

  for (const Track& track : t.tracks) {
    if (track.missed > 0) continue;
    if (!track.published) {
      ++counters.unconfirmed;
      continue;
    }
    const Point& point = points[track.point];
    TrackedPoint& out = tracked.emplace_back();
    out.id = track.id;
    out.position_in_world = point.position_in_world;
    out.velocity_in_world = track.motion.velocity();
    out.covariance_m2 = point.covariance_m2;
    out.residual_px = point.rms_px;
    out.point = track.point;
    for (std::size_t camera = 0; camera < kMatchCameras; ++camera)
      if (point.blob_of_camera[camera] >= 0) out.cameras |= std::uint32_t{1} << camera;
  }
  counters.published += tracked.size();
}

// The matcher has weighed predicted points against each other already; only the gate is checked again.
void Tracker::Impl::take_predicted(std::span<const Point> points) {
  for (std::uint32_t k = 0; k < points.size(); ++k) {
    if (points[k].predicted_by == TrackId{}) continue;
    const auto found =
        std::lower_bound(tracks.begin(), tracks.end(), points[k].predicted_by,
                         [](const Track& track, TrackId id) { return number(track.id) < number(id); });
    if (found == tracks.end() || found->id != points[k].predicted_by || found->point != kUnassigned) continue;
    if (found->motion.distance2(points[k].position_in_world, measurement_covariance(points[k])) > kGateChi2)
      continue;
    found->point = k;
    point_taken[k] = 1;
  }
}

void Tracker::Impl::sort_points(std::span<const Point> points) {
  points_by_x.clear();
  for (std::uint32_t k = 0; k < points.size(); ++k)
    if (point_taken[k] == 0) points_by_x.push_back(k);
  std::sort(points_by_x.begin(), points_by_x.end(), [points](std::uint32_t a, std::uint32_t b) {
    const double xa = points[a].position_in_world.x(), xb = points[b].position_in_world.x();
    return xa != xb ? xa < xb : a < b;
  });
}

template <typename Visit>
void Tracker::Impl::free_points_near(std::span<const Point> points, const Eigen::Vector3d& centre,
                                     double reach_m, Visit&& visit) {
  auto it =
      std::lower_bound(points_by_x.begin(), points_by_x.end(), centre.x() - reach_m,
                       [points](std::uint32_t k, double x) { return points[k].position_in_world.x() < x; });
  for (; it != points_by_x.end() && points[*it].position_in_world.x() <= centre.x() + reach_m; ++it)
    if (point_taken[*it] == 0 && (points[*it].position_in_world - centre).squaredNorm() <= reach_m * reach_m)
      visit(*it);
}

void Tracker::Impl::assign_by_likelihood(std::span<const Point> points) {
  edges.clear();
  row_track.clear();
  for (std::uint32_t k = 0; k < tracks.size(); ++k) {
    const Track& track = tracks[k];
    if (track.point != kUnassigned) continue;
    const auto row = static_cast<std::uint32_t>(row_track.size());
    row_track.push_back(k);
    // The gate's ellipsoid lies inside this ball; a point's own covariance is the smaller part by far.
    const double reach = 1.5 * std::sqrt(kGateChi2 * track.motion.position_covariance().trace()) + 0.01;
    free_points_near(points, track.motion.position(), reach, [&](std::uint32_t point) {
      // A new track's velocity is unknown, but not unlimited.
      const double moved = (points[point].position_in_world - track.measured_at).norm();
      if (moved > options.max_speed_m_s * track.since_measured_s + kStandStill_m) return;
      const Eigen::Matrix3d r = measurement_covariance(points[point]);
      const double distance2 = track.motion.distance2(points[point].position_in_world, r);
      if (!(distance2 <= kGateChi2)) return;
      const double log_density =
          -0.5 * distance2 -
          0.5 * std::log((2.0 * M_PI * (track.motion.position_covariance() + r)).determinant());
      edges.push_back({row, point, std::max(1e-3, log_density - std::log(kNewPointDensity))});
    });
  }
  assignment.solve(row_track.size(), points.size(), edges, column_of_row);
  for (std::size_t row = 0; row < row_track.size(); ++row) {
    if (column_of_row[row] == kUnassigned) continue;
    tracks[row_track[row]].point = column_of_row[row];
    point_taken[column_of_row[row]] = 1;
  }
}

// Second chance for a marker whose velocity turned round between two exposures: it is where its speed could
// take it, in whatever direction, and no other lost track or new point is there to be confused with.
void Tracker::Impl::assign_bounces(std::span<const Point> points) {
  edges.clear();
  edges_of_point.assign(points.size(), 0);
  for (std::uint32_t k = 0; k < tracks.size(); ++k) {
    const Track& track = tracks[k];
    if (track.point != kUnassigned || !track.published || track.missed >= kBounceFrames) continue;
    const double speed = std::min(
        options.max_speed_m_s, kBounceSpeedFactor * track.motion.velocity().norm() + kBounceSpeedOffset_m_s);
    const std::size_t before = edges.size();
    free_points_near(points, track.measured_at, speed * track.since_measured_s, [&](std::uint32_t point) {
      edges.push_back({k, point, 1.0});
      ++edges_of_point[point];
    });
    if (edges.size() > before + 1)
      for (std::size_t e = before; e < edges.size(); ++e) edges[e].gain = 0.0;
  }
  for (const AssignmentEdge& edge : edges) {
    if (edge.gain == 0.0 || edges_of_point[edge.column] != 1) continue;
    Track& track = tracks[edge.row];
    track.point = edge.column;
    point_taken[edge.column] = 1;
  }
}

void Tracker::Impl::correct(Track& track, const Point& point) {
  const Eigen::Matrix3d r = measurement_covariance(point);
  if (track.motion.distance2(point.position_in_world, r) > kGateChi2) {
    // A bounce: nothing is left of the old velocity but its size.
    const double speed = track.motion.velocity().norm() + kBounceSpeedOffset_m_s;
    track.motion = Motion(point.position_in_world, r, speed);
  } else {
    if (track.seen > 1 && step_s > 0.0 && track.motion.distance2(point.position_in_world, r) > kSurpriseChi2)
      track.motion.loosen_velocity((point.position_in_world - track.motion.position()).norm() / step_s);
    track.motion.correct(point.position_in_world, r);
  }
  track.measured_at = point.position_in_world;
  track.since_measured_s = 0.0;
  track.missed = 0;
  ++track.seen;
  track.published = track.published || point.views >= 3 || track.seen >= options.confirm_frames_two_views;
}

void Tracker::Impl::start(const Point& point, std::uint32_t point_number) {
  tracks.push_back(
      {TrackId{next_id++},
       Motion(point.position_in_world, measurement_covariance(point), options.max_speed_m_s / 3.0),
       point.position_in_world, 0.0, 1, 0, point.views >= 3 || options.confirm_frames_two_views <= 1,
       point_number});
}

}  // namespace glint
