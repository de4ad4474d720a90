// SPDX-License-Identifier: MIT
// Birth, life and death of tracks.
#include "host/track/tracker.hpp"

#include <algorithm>
#include <cmath>

#include <Eigen/LU>

#include "host/base/error.hpp"
#include "host/track/assignment.hpp"
#include "host/track/motion.hpp"
#include "host/track/track.hpp"
#include "host/track/view_learning.hpp"

namespace glint {
namespace {

// Chi-square, three degrees of freedom: 25 is exceeded once in 65,000 by a marker that moves as the models
// say, and such markers are what the gate is for.
constexpr double kGateChi2 = 25.0;
// Triangulation does not know all of its errors; below this the filter would trust it blindly.
constexpr double kMeasurementFloor_m = 1e-6;
// Points of unknown origin per cubic metre and frame: what an assignment must beat. Only its logarithm
// counts.
constexpr double kNewPointDensity = 0.01;
constexpr double kStandStill_m = 0.01;  // how far measurements of a marker at rest may lie apart, generously
constexpr double kLost_m = 0.1;         // a position known no better is no position
// Where a track is known so well, and was so few frames ago, a bad view cannot have misled it unless it is
// this far from what was expected (5 %, three degrees of freedom).
constexpr double kSharp_m = 2e-3, kAsExpectedChi2 = 7.8;
constexpr unsigned kFewFrames = 2;
// A marker that is dull in all cameras is no sliver of a bright one: so many frames tell.
constexpr unsigned kDullFrames = 10;
// A point this near to a track that has its own (squared Mahalanobis distance) is a second look at the same
// marker.
constexpr double kSameChi2 = 16.0;

constexpr std::size_t kTracksReserved = 512, kEventsReserved = 1024;

// Tracks farther apart than this many standard deviations, or than this, cannot have each other's points.
constexpr double kQuestionSigmas = 6.0, kQuestionReach_m = 0.15;

constexpr double kFloor_m2 = kMeasurementFloor_m * kMeasurementFloor_m;

Eigen::Matrix3d measurement_covariance(const Point& point) noexcept {
  return point.covariance_m2 + kFloor_m2 * Eigen::Matrix3d::Identity();
}

// With the floor: (L^-1 + f I)^-1 = (I + f L)^-1 L, which also holds where one view leaves a direction open.
PositionEvidence evidence_of(const Point& point) noexcept {
  PositionEvidence e{point.position_in_world, point.information_per_m2, point.gradient_per_m};
  if (e.information_per_m2.isZero(0.0)) {  // a point that is not of views, but of a plane
    e.information_per_m2 = measurement_covariance(point).inverse();
    return e;
  }
  const Eigen::Matrix3d blunt = (Eigen::Matrix3d::Identity() + kFloor_m2 * e.information_per_m2).inverse();
  e.information_per_m2 = blunt * e.information_per_m2;
  e.gradient_per_m = blunt * e.gradient_per_m;
  return e;
}

bool is_as_expected(const Track& track, const Point& point) noexcept {
  const Eigen::Matrix3d& expected = track.motion.position_covariance();
  if (track.age > kFewFrames || expected.trace() > kSharp_m * kSharp_m) return false;
  const Eigen::Vector3d away = point.position_in_world - track.motion.position();
  return away.dot((expected + measurement_covariance(point)).inverse() * away) < kAsExpectedChi2;
}

}  // namespace

struct Tracker::Impl {
  Impl(const TrackOptions& given, std::span<const double> calibration_sd_px) : options(given) {
    for (const double sd_px : calibration_sd_px) calibration_px2.push_back(sd_px * sd_px);
    tracks.reserve(kTracksReserved);
    events.reserve(kEventsReserved);
  }

  void take_claims(std::span<const Point> points, bool single_view);
  void assign_by_likelihood(std::span<const Point> points);
  void correct(Track& track, std::span<const Point> points);
  void start(const Point& point, std::uint32_t number);
  bool is_second_look(const Point& point) const;
  Doubts::Seen seen(const Track& track) const noexcept;
  Track* find(TrackId id) noexcept;
  void question_identities(std::span<const Point> points, TrackCounters& counters);
  TrackId new_id_of(TrackId old_id) noexcept;
  void rename(Track* track, TrackId id) noexcept;
  void answer_questions(TrackCounters& counters);
  void publish(const Track& track, std::span<const Point> points, std::vector<TrackedPoint>& tracked) const;
  void sort_points(std::span<const Point> points);
  template <typename Visit>
  void free_points_near(std::span<const Point> points, const Eigen::Vector3d& centre, double reach_m,
                        Visit&& visit);

  const TrackOptions options;
  std::vector<double> calibration_px2;  // by camera, variance per axis
  std::vector<Track> tracks;            // ascending ids
  std::uint32_t next_id = 1;
  bool started = false;
  Timestamp now{};
  double step_s = 0.0;

  std::vector<std::uint8_t> point_taken;
  std::vector<std::uint32_t> points_by_x, column_of_row, row_track;
  std::vector<AssignmentEdge> edges;
  Assignment assignment;
  std::vector<PositionEvidence> evidence;  // by point
  std::vector<std::uint32_t> tracks_by_x;
  Doubts doubts;
  std::vector<IdentityEvent> events;
};

Tracker::Tracker(const TrackOptions& options, std::span<const double> calibration_sd_px) {
  std::vector<std::string> problems;
  options.check(problems);
  if (!problems.empty()) throw Error(problems.front());
  impl_ = std::make_unique<Impl>(options, calibration_sd_px);
}

Tracker::~Tracker() = default;

void Tracker::predict(Timestamp exposed, std::vector<Prediction>& predictions) {
  Impl& t = *impl_;
  // Exposures that come out of order are no reason to run backwards.
  t.step_s = t.started ? std::max(0.0, seconds_between(t.now, exposed)) : 0.0;
  t.started = true;
  t.now = std::max(t.now, exposed);
  predictions.clear();
  t.doubts.advance(t.step_s, t.options.acceleration_sd_m_s2);
  for (Track& track : t.tracks) {
    track.motion.advance(t.step_s, t.options.acceleration_sd_m_s2);
    track.since_measured_s += t.step_s;
    track.point = kNoPoint;
    forget_bias(track, t.step_s, t.calibration_px2);
  }
  for (Track& track : t.tracks) {
    ask_neighbours(track, t.tracks, t.calibration_px2);
    Prediction& p = predictions.emplace_back();
    p.track = track.id;
    p.position_in_world = track.motion.position();
    p.covariance_m2 = track.motion.position_covariance();
    p.velocity_in_world = track.motion.velocity();
    p.modes = track.motion.modes();
    p.mode_count = kMotionModes;
    p.bias = std::span(track.bias).first(t.calibration_px2.size());
    p.brightness = track.brightness;
    p.single_view = track.published && track.seen >= kSettledFrames;
  }
}

void Tracker::update(std::span<const Point> points, std::vector<TrackedPoint>& tracked,
                     TrackCounters& counters) {
  Impl& t = *impl_;
  tracked.clear();
  t.point_taken.assign(points.size(), 0);
  t.take_claims(points, false);
  t.sort_points(points);
  t.assign_by_likelihood(points);
  t.take_claims(points, true);
  t.events.clear();
  t.question_identities(points, counters);

  for (Track& track : t.tracks) {
    if (track.point == kNoPoint) {
      ++track.missed;
      ++track.age;
      continue;
    }
    t.correct(track, points);
  }
  t.answer_questions(counters);
  // A track that was never shown must be seen in every frame; one that was may be hidden for a while.
  const auto ended = std::remove_if(t.tracks.begin(), t.tracks.end(), [&](const Track& track) {
    return track.missed > (track.published ? t.options.max_missed_frames : 0u) ||
           (track.age > 0 && track.motion.position_covariance().trace() > kLost_m * kLost_m);
  });
  counters.ended += static_cast<std::uint64_t>(t.tracks.end() - ended);
  t.tracks.erase(ended, t.tracks.end());
  for (std::uint32_t k = 0; k < points.size(); ++k) {
    if (t.point_taken[k] != 0 || t.is_second_look(points[k])) continue;
    t.start(points[k], k);
    ++counters.started;
  }

  for (const Track& track : t.tracks) {
    if (track.published) {
      t.publish(track, points, tracked);
    } else {
      ++counters.unconfirmed;
    }
  }
  counters.published += tracked.size();
}

void Tracker::Impl::publish(const Track& track, std::span<const Point> points,
                            std::vector<TrackedPoint>& tracked) const {
  if (track.age > 0 &&
      track.motion.position_covariance().trace() > 3.0 * std::pow(options.max_predicted_sd_m, 2))
    return;
  TrackedPoint& out = tracked.emplace_back();
  out.id = track.id;
  out.position_in_world = track.motion.position();
  out.velocity_in_world = track.motion.velocity();
  out.covariance_m2 = track.motion.position_covariance() + track.calibration_covariance_m2;
  out.age_frames = track.age;
  out.point = track.point;
  out.ambiguous_with = doubts.other_of(track.id);
  if (track.point == kNoPoint) {
    out.kind = SampleKind::Predicted;
    return;
  }
  const Point& point = points[track.point];
  out.kind = track.age > 0 ? SampleKind::SingleView : SampleKind::Measured;
  out.residual_px = point.rms_px;
  for (std::size_t camera = 0; camera < kMatchCameras; ++camera)
    if (point.blob_of_camera[camera] >= 0) out.cameras |= std::uint32_t{1} << camera;
}

std::span<const IdentityEvent> Tracker::events() const noexcept { return impl_->events; }

Track* Tracker::Impl::find(TrackId id) noexcept {
  const auto found =
      std::lower_bound(tracks.begin(), tracks.end(), id,
                       [](const Track& track, TrackId wanted) { return number(track.id) < number(wanted); });
  return found != tracks.end() && found->id == id ? &*found : nullptr;
}

Doubts::Seen Tracker::Impl::seen(const Track& track) const noexcept {
  return {track.id, &track.motion, track.point == kNoPoint ? nullptr : &evidence[track.point]};
}

// Could two tracks that are near each other have each other's points? However the points came to them, and
// before they are corrected by them.
void Tracker::Impl::question_identities(std::span<const Point> points, TrackCounters& counters) {
  evidence.clear();
  for (const Point& point : points) evidence.push_back(evidence_of(point));
  doubts.weigh([this](TrackId id) {
    const Track* const track = find(id);
    return track == nullptr ? std::nullopt : std::optional(seen(*track));
  });
  tracks_by_x.clear();
  for (std::uint32_t k = 0; k < tracks.size(); ++k)
    if (tracks[k].published) tracks_by_x.push_back(k);
  const auto at = [this](std::uint32_t k) -> const Eigen::Vector3d& { return tracks[k].motion.position(); };
  std::sort(tracks_by_x.begin(), tracks_by_x.end(),
            [&](std::uint32_t a, std::uint32_t b) { return at(a).x() < at(b).x(); });
  const auto reach_of = [points](const Track& track) {
    const bool claimed = track.point != kNoPoint && points[track.point].predicted_by != TrackId{};
    return std::min(kQuestionReach_m,
                    kQuestionSigmas * std::sqrt(track.motion.position_covariance().trace()) +
                        (claimed ? 0.0 : track.motion.impact_reach_m()));
  };
  for (std::size_t i = 0; i < tracks_by_x.size(); ++i) {
    const Track& a = tracks[tracks_by_x[i]];
    const double reach = reach_of(a);
    for (std::size_t j = i + 1; j < tracks_by_x.size(); ++j) {
      const Track& b = tracks[tracks_by_x[j]];
      if (b.motion.position().x() - a.motion.position().x() > reach + kQuestionReach_m) break;
      const double both = reach + reach_of(b);
      if ((b.motion.position() - a.motion.position()).squaredNorm() > both * both) continue;
      if (!doubts.consider(seen(a), seen(b))) continue;
      events.push_back({IdentityEvent::Kind::Ambiguous, a.id, b.id, {}, {}});
      ++counters.ambiguous;
    }
  }
}

// The same one where a track is in several pairs that end unresolved at once.
TrackId Tracker::Impl::new_id_of(TrackId old_id) noexcept {
  for (const IdentityEvent& event : events) {
    if (event.kind != IdentityEvent::Kind::Unresolved) continue;
    if (event.a == old_id && event.new_a != TrackId{}) return event.new_a;
    if (event.b == old_id && event.new_b != TrackId{}) return event.new_b;
  }
  return TrackId{next_id++};
}

// After the correction, so that what is put in the place of a track knows of this exposure, too.
void Tracker::Impl::answer_questions(TrackCounters& counters) {
  bool renamed = false;
  // What ends is told before what begins: a pair may be in doubt anew.
  const std::size_t begun = events.size();
  for (const Doubts::Verdict& verdict : doubts.verdicts()) {
    Track *const a = find(verdict.a), *const b = find(verdict.b);
    IdentityEvent event{IdentityEvent::Kind::Kept, verdict.a, verdict.b, {}, {}};
    if (!verdict.decided) {
      event.kind = IdentityEvent::Kind::Unresolved;
      if (a != nullptr) event.new_a = new_id_of(verdict.a);
      if (b != nullptr) event.new_b = new_id_of(verdict.b);
      ++counters.unresolved;
    } else if (verdict.swapped) {
      event.kind = IdentityEvent::Kind::Swapped;
      std::swap(*a, *b);
      std::swap(a->id, b->id);
      a->motion = verdict.a_motion;
      b->motion = verdict.b_motion;
      ++counters.swapped;
    } else {
      ++counters.kept;
    }
    events.push_back(event);
    renamed = renamed || event.kind == IdentityEvent::Kind::Unresolved;
  }
  std::rotate(events.begin(), events.begin() + static_cast<std::ptrdiff_t>(begun), events.end());
  if (!renamed) return;
  for (const IdentityEvent& event : events) {
    if (event.kind != IdentityEvent::Kind::Unresolved) continue;
    // Both are looked up before the order of ids is lost.
    Track *const a = find(event.a), *const b = find(event.b);
    rename(a, event.new_a);
    rename(b, event.new_b);
    std::sort(tracks.begin(), tracks.end(),
              [](const Track& p, const Track& q) { return number(p.id) < number(q.id); });
  }
}

void Tracker::Impl::rename(Track* track, TrackId id) noexcept {
  if (track == nullptr) return;
  doubts.rename(track->id, id);
  track->id = id;
}

// The matcher has weighed all claims against each other, and against what each track expects.
void Tracker::Impl::take_claims(std::span<const Point> points, bool single_view) {
  for (std::uint32_t k = 0; k < points.size(); ++k) {
    if (points[k].predicted_by == TrackId{}) continue;
    point_taken[k] = 1;  // of one view and refused, it is no new point either
    if ((points[k].views == 1) != single_view) continue;
    Track* const track = find(points[k].predicted_by);
    if (track != nullptr && track->point == kNoPoint) track->point = k;
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
    if (track.point != kNoPoint) continue;
    const auto row = static_cast<std::uint32_t>(row_track.size());
    row_track.push_back(k);
    // The gate's ellipsoid lies inside this ball; a point's own covariance is the smaller part by far.
    const double reach = 1.5 * std::sqrt(kGateChi2 * track.motion.position_covariance().trace()) + 0.01;
    const double impact_reach = track.published ? track.motion.impact_reach_m() : 0.0;
    free_points_near(
        points, track.motion.position(), std::max(reach, 2.0 * impact_reach), [&](std::uint32_t point) {
          // A new track's velocity is unknown, but not unlimited.
          const double moved = (points[point].position_in_world - track.measured_at).norm();
          if (moved > options.max_speed_m_s * track.since_measured_s + kStandStill_m) return;
          const Eigen::Matrix3d r = measurement_covariance(points[point]);
          if (track.motion.distance2(points[point].position_in_world, r) > kGateChi2 &&
              !(moved < impact_reach))
            return;
          const double weight =
              track.motion.log_density(points[point].position_in_world, r) - std::log(kNewPointDensity);
          if (weight > 0.0) edges.push_back({row, point, weight});
        });
  }
  assignment.solve(row_track.size(), points.size(), edges, column_of_row);
  for (std::size_t row = 0; row < row_track.size(); ++row) {
    if (column_of_row[row] == kUnassigned) continue;
    tracks[row_track[row]].point = column_of_row[row];
    point_taken[column_of_row[row]] = 1;
  }
}

void Tracker::Impl::correct(Track& track, std::span<const Point> points) {
  const Point& point = points[track.point];
  ++track.age;
  track.missed = 0;
  learn_brightness(track, point);
  // Views of which only one shows all of a marker tell its distance no better than one does. A rig of two
  // cameras has nothing better.
  const bool blurred = point.doubtful && calibration_px2.size() > 2 && track.seen >= kSettledFrames &&
                       !is_as_expected(track, point);
  track.motion.correct(evidence[track.point]);
  learn_bias(track, point, calibration_px2);
  if ((point.views == 1 || blurred) && point.predicted_by != TrackId{}) return;
  track.calibration_covariance_m2 = point.calibration_covariance_m2;
  track.measured_at = point.position_in_world;
  track.since_measured_s = 0.0;
  track.age = 0;
  ++track.seen;
  track.published = track.published || point.certain ||
                    track.seen >= (point.doubtful ? kDullFrames : options.confirm_frames_two_views);
}

void Tracker::Impl::start(const Point& point, std::uint32_t point_number) {
  Track& track = tracks.emplace_back(Track{TrackId{next_id++},
                                           Motion(point.position_in_world, measurement_covariance(point),
                                                  options.max_speed_m_s / 3.0, options.acceleration_sd_m_s2),
                                           point.position_in_world});
  track.published = point.certain || options.confirm_frames_two_views <= 1;
  track.point = point_number;
  track.calibration_covariance_m2 = point.calibration_covariance_m2;
  for (std::size_t camera = 0; camera < calibration_px2.size(); ++camera)
    track.bias[camera].variance_px2 = calibration_px2[camera];
  ask_neighbours(track, tracks, calibration_px2);
  learn_bias(track, point, calibration_px2);
}

bool Tracker::Impl::is_second_look(const Point& point) const {
  return std::any_of(tracks.begin(), tracks.end(), [&](const Track& track) {
    if (track.point == kNoPoint || track.age > 0) return false;
    const Eigen::Vector3d d = point.position_in_world - track.motion.position();
    if (d.squaredNorm() > kStandStill_m * kStandStill_m) return false;
    const Eigen::Matrix3d s = track.motion.position_covariance() + track.calibration_covariance_m2 +
                              measurement_covariance(point) + point.calibration_covariance_m2;
    return d.dot(s.inverse() * d) < kSameChi2;
  });
}

}  // namespace glint
