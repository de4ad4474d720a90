// SPDX-License-Identifier: MIT
// Rigid groups, then alternating least squares.
#include "host/body/learn.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <map>
#include <optional>

#include "host/base/error.hpp"
#include "host/body/point_pose.hpp"
#include "host/geometry/rotation.hpp"

namespace glint {
namespace {

constexpr int kRounds = 50;             // of averaging; five are usual
constexpr double kSettled_m = 1e-7;     // a round that moves no marker by more is the last
constexpr double kLeastSd_m = 1e-4;     // nobody knows more: spheres are not mounted better than that
constexpr double kOneMarker_m = 0.005;  // tracks nearer to each other than this are of one marker
constexpr double kOutlierSigmas = 4.0;

struct Sight {
  std::uint32_t tick;
  Eigen::Vector3d position;
};
struct Seen {
  TrackId id;
  std::vector<Sight> sights;  // ascending ticks
};

std::string text(const char* format, double value) {
  char buffer[64];
  std::snprintf(buffer, sizeof buffer, format, value);
  return buffer;
}

double median(std::vector<double>& values) {
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

enum class Bond : std::uint8_t { Unknown, Rigid, Loose };

Bond bond_of(const Seen& a, const Seen& b, const LearnOptions& options, std::vector<double>& room) {
  room.clear();
  for (std::size_t i = 0, j = 0; i < a.sights.size() && j < b.sights.size();) {
    if (a.sights[i].tick < b.sights[j].tick)
      ++i;
    else if (a.sights[i].tick > b.sights[j].tick)
      ++j;
    else
      room.push_back((a.sights[i++].position - b.sights[j++].position).norm());
  }
  if (room.size() < options.min_frames) return Bond::Unknown;
  const double distance = median(room);
  for (double& d : room) d = std::abs(d - distance);
  // 1.48 times the median deviation is the standard deviation of a normal distribution.
  return distance <= options.max_diameter_m && 1.48 * median(room) <= options.max_distance_sd_m ? Bond::Rigid
                                                                                                : Bond::Loose;
}

std::vector<Seen> tracks_of(std::span<const RecordedTick> ticks, const LearnOptions& options,
                            Learnt& learnt) {
  std::map<std::uint32_t, Seen> by_id;
  for (std::uint32_t tick = 0; tick < ticks.size(); ++tick)
    for (const RecordedSample& sample : ticks[tick]) {
      Seen& seen = by_id[number(sample.track)];
      seen.id = sample.track;
      if (!sample.position_in_world.allFinite()) continue;
      if (!seen.sights.empty() && seen.sights.back().tick == tick) continue;
      seen.sights.push_back({tick, sample.position_in_world});
    }
  std::vector<Seen> tracks;
  std::size_t brief = 0;
  for (auto& [id, seen] : by_id) {
    if (seen.sights.size() >= options.min_frames)
      tracks.push_back(std::move(seen));
    else
      ++brief;
  }
  if (brief > 0)
    learnt.remarks.push_back(std::to_string(brief) + (brief == 1 ? " track was" : " tracks were") +
                             " seen in fewer than " + std::to_string(options.min_frames) +
                             " frames and left out");
  return tracks;
}

/// Sets of tracks that are rigid wherever they were seen together; each track is in one at most.
std::vector<std::vector<std::uint32_t>> rigid_groups(const std::vector<Seen>& tracks,
                                                     const LearnOptions& options) {
  const std::size_t n = tracks.size();
  std::vector<Bond> bonds(n * n, Bond::Unknown);
  std::vector<double> room;
  for (std::size_t i = 0; i < n; ++i)
    for (std::size_t j = i + 1; j < n; ++j)
      bonds[i * n + j] = bonds[j * n + i] = bond_of(tracks[i], tracks[j], options, room);
  std::vector<std::uint32_t> order(n);
  for (std::uint32_t k = 0; k < n; ++k) order[k] = k;
  std::stable_sort(order.begin(), order.end(), [&](std::uint32_t a, std::uint32_t b) {
    return tracks[a].sights.size() > tracks[b].sights.size();
  });
  std::vector<bool> taken(n);
  std::vector<std::vector<std::uint32_t>> groups;
  for (const std::uint32_t seed : order) {
    if (taken[seed]) continue;
    std::vector<std::uint32_t> group{seed};
    for (bool grown = true; grown;) {
      grown = false;
      for (const std::uint32_t k : order) {
        if (taken[k] || std::find(group.begin(), group.end(), k) != group.end()) continue;
        std::size_t rigid = 0;
        bool loose = false;
        for (const std::uint32_t member : group) {
          rigid += bonds[k * n + member] == Bond::Rigid ? 1u : 0u;
          loose = loose || bonds[k * n + member] == Bond::Loose;
        }
        if (loose || rigid < std::min<std::size_t>(group.size(), 3)) continue;
        group.push_back(k);
        grown = true;
      }
    }
    if (group.size() < 3) continue;
    for (const std::uint32_t member : group) taken[member] = true;
    groups.push_back(std::move(group));
  }
  return groups;
}

/// One body while it is being averaged.
class Average {
 public:
  Average(const std::vector<Seen>& tracks, std::vector<std::uint32_t> group) {
    for (const std::uint32_t member : group) {
      markers_.push_back({});
      for (const Sight& sight : tracks[member].sights)
        ticks_[sight.tick].push_back({static_cast<std::uint32_t>(markers_.size() - 1), sight.position});
    }
  }

  bool converge() {
    if (!start()) return false;
    for (int round = 0; round < kRounds; ++round)
      if (step() < kSettled_m && round > 1) return true;
    return true;
  }

  /// Tracks in one place become one marker.
  void join() {
    std::vector<std::uint32_t> name(markers_.size());
    std::vector<Marker> kept;
    for (std::uint32_t k = 0; k < markers_.size(); ++k) {
      name[k] = static_cast<std::uint32_t>(kept.size());
      for (std::uint32_t other = 0; other < kept.size(); ++other)
        if (markers_[k].known && (kept[other].place - markers_[k].place).norm() < kOneMarker_m)
          name[k] = other;
      if (!markers_[k].known)
        name[k] = kUnknown;
      else if (name[k] == kept.size())
        kept.push_back(markers_[k]);
    }
    for (auto& [tick, sights] : ticks_) {
      for (auto& sight : sights) sight.marker = name[sight.marker];
      std::erase_if(sights, [](const auto& sight) { return sight.marker == kUnknown; });
    }
    markers_ = std::move(kept);
  }

  LearntBody result() const {
    LearntBody body;
    std::vector<Eigen::Vector3d> places;
    for (const Marker& marker : markers_) places.push_back(marker.place);
    body.model.markers_in_body = in_own_frame(places);
    double squares = 0.0;
    std::size_t count = 0;
    std::optional<Pose> first;
    for (const auto& [tick, sights] : ticks_) {
      const auto pose = pose_of(sights);
      if (!pose) continue;
      ++body.frames;
      if (!first) first = pose;
      body.turn_rad =
          std::max(body.turn_rad, rotation_vector_of(pose->rotation * first->rotation.conjugate()).norm());
      body.path_m = std::max(body.path_m, (*pose * places[0] - *first * places[0]).norm());
      for (const auto& sight : sights) {
        const double square = (pose->inverse() * sight.position - places[sight.marker]).squaredNorm();
        if (square > 3.0 * kOutlierSigmas * kOutlierSigmas * sd_ * sd_) continue;
        squares += square;
        ++count;
      }
    }
    // Six numbers of each pose were fitted to the markers that they are compared with.
    const double free = 3.0 * static_cast<double>(count) - 6.0 * static_cast<double>(body.frames);
    body.scatter_m = free > 0.0 ? std::sqrt(squares / free) : 0.0;
    body.model.marker_sd_m = std::max(kLeastSd_m, body.scatter_m);
    return body;
  }

 private:
  static constexpr std::uint32_t kUnknown = 0xffffffffu;
  struct Marker {
    Eigen::Vector3d place = Eigen::Vector3d::Zero();
    bool known = false;
  };
  struct MarkerSight {
    std::uint32_t marker;
    Eigen::Vector3d position;
  };

  // The exposure with most markers is the first model.
  bool start() {
    const std::vector<MarkerSight>* best = nullptr;
    for (const auto& [tick, sights] : ticks_)
      if (best == nullptr || sights.size() > best->size()) best = &sights;
    if (best == nullptr || best->size() < 3) return false;
    for (const MarkerSight& sight : *best) markers_[sight.marker] = {sight.position, true};
    return true;
  }

  std::optional<Pose> pose_of(const std::vector<MarkerSight>& sights) const {
    std::vector<Eigen::Vector3d> in_body, in_world;
    for (const MarkerSight& sight : sights) {
      if (!markers_[sight.marker].known) continue;
      in_body.push_back(markers_[sight.marker].place);
      in_world.push_back(sight.position);
    }
    return pose_from_points(in_body, in_world);
  }

  // Poses from markers, markers from poses; by how much the farthest moved one moved.
  double step() {
    std::vector<Eigen::Vector3d> sum(markers_.size(), Eigen::Vector3d::Zero());
    std::vector<double> weight(markers_.size(), 0.0);
    double squares = 0.0, count = 0.0;
    for (const auto& [tick, sights] : ticks_) {
      const auto pose = pose_of(sights);
      if (!pose) continue;
      const Pose body_from_world = pose->inverse();
      for (const MarkerSight& sight : sights) {
        const Eigen::Vector3d place = body_from_world * sight.position;
        const Marker& marker = markers_[sight.marker];
        const double square = (place - marker.place).squaredNorm();
        if (marker.known && sd_ > 0.0 && square > 3.0 * kOutlierSigmas * kOutlierSigmas * sd_ * sd_) continue;
        sum[sight.marker] += place;
        weight[sight.marker] += 1.0;
        if (marker.known) squares += square;
        if (marker.known) count += 3.0;
      }
    }
    if (count > 0.0) sd_ = std::max(kLeastSd_m, std::sqrt(squares / count));
    double moved = 0.0;
    for (std::size_t k = 0; k < markers_.size(); ++k) {
      if (weight[k] == 0.0) continue;
      const Eigen::Vector3d place = sum[k] / weight[k];
      moved = markers_[k].known ? std::max(moved, (place - markers_[k].place).norm()) : 1.0;
      markers_[k] = {place, true};
    }
    return moved;
  }

  static std::vector<Eigen::Vector3d> in_own_frame(std::vector<Eigen::Vector3d> places) {
    Eigen::Vector3d mean = Eigen::Vector3d::Zero();
    for (const Eigen::Vector3d& p : places) mean += p / static_cast<double>(places.size());
    for (Eigen::Vector3d& p : places) p -= mean;
    std::sort(places.begin(), places.end(), [](const Eigen::Vector3d& a, const Eigen::Vector3d& b) {
      return a.squaredNorm() > b.squaredNorm();
    });
    const Eigen::Vector3d x = places[0].normalized();
    const auto off_axis = [&x](const Eigen::Vector3d& p) { return (p - x.dot(p) * x).eval(); };
    const auto second = std::max_element(places.begin() + 1, places.end(), [&](const auto& a, const auto& b) {
      return off_axis(a).squaredNorm() < off_axis(b).squaredNorm();
    });
    std::rotate(places.begin() + 1, second, second + 1);
    Eigen::Matrix3d axes;
    axes.row(0) = x;
    axes.row(1) = off_axis(places[1]).normalized();
    axes.row(2) = x.cross(axes.row(1).transpose());
    for (Eigen::Vector3d& p : places) p = (axes * p).eval();
    return places;
  }

  std::vector<Marker> markers_;
  std::map<std::uint32_t, std::vector<MarkerSight>> ticks_;
  double sd_ = 0.0;
};

}  // namespace

void LearnOptions::check(std::vector<std::string>& problems) const {
  if (!(max_distance_sd_m > 0.0)) problems.emplace_back("learn.max_distance_sd_m must be > 0");
  if (!(max_diameter_m > 0.0)) problems.emplace_back("learn.max_diameter_m must be > 0");
  if (min_frames < 10) problems.emplace_back("learn.min_frames must be >= 10");
}

Learnt learn_bodies(std::span<const RecordedTick> ticks, const LearnOptions& options) {
  std::vector<std::string> problems;
  options.check(problems);
  if (!problems.empty()) throw Error(problems.front());
  Learnt learnt;
  if (ticks.size() < options.min_frames) {
    learnt.remarks.push_back("only " + std::to_string(ticks.size()) + " frames; record at least " +
                             std::to_string(options.min_frames) + ", better some hundred");
    return learnt;
  }
  const std::vector<Seen> tracks = tracks_of(ticks, options, learnt);
  const auto groups = rigid_groups(tracks, options);
  if (groups.empty())
    learnt.remarks.push_back("nothing rigid: no three of " + std::to_string(tracks.size()) +
                             " tracks keep their distances within " +
                             text("%.1f mm", 1e3 * options.max_distance_sd_m));
  for (const auto& group : groups) {
    const std::string who = "a group of " + std::to_string(group.size()) + " tracks (the first is " +
                            std::to_string(number(tracks[group.front()].id)) + ") ";
    Average average(tracks, group);
    if (!average.converge()) {
      learnt.remarks.push_back(who + "is never seen with three markers at once");
      continue;
    }
    average.join();
    average.converge();
    LearntBody body = average.result();
    if (body.turn_rad < options.min_turn_rad && body.path_m < options.min_path_m) {
      learnt.remarks.push_back(who + "moved by only " + text("%.0f mm", 1e3 * body.path_m) +
                               " and turned by " + text("%.0f degrees", body.turn_rad * 180.0 / M_PI) +
                               ": it may be several bodies that stand still; move and turn it");
      continue;
    }
    body.model.name = "body";  // for the check alone
    std::vector<std::string> unfit;
    body.model.check(unfit);
    if (!unfit.empty()) {
      learnt.remarks.push_back(who + "is rigid but no body: " + unfit.front());
      continue;
    }
    learnt.bodies.push_back(std::move(body));
  }
  std::stable_sort(learnt.bodies.begin(), learnt.bodies.end(), [](const LearntBody& a, const LearntBody& b) {
    return a.model.markers_in_body.size() > b.model.markers_in_body.size();
  });
  for (std::size_t k = 0; k < learnt.bodies.size(); ++k)
    learnt.bodies[k].model.name = "body" + std::to_string(k + 1);
  return learnt;
}

}  // namespace glint
