// SPDX-License-Identifier: MIT
#include "host/calibrate/rig_start.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>

#include "host/base/error.hpp"
#include "host/calibrate/pnp.hpp"
#include "host/calibrate/relative_pose.hpp"
#include "host/calibrate/sighting_model.hpp"

namespace glint {
namespace {

constexpr std::uint64_t kFewestTicks = 20;  // of a pair: fewer do not fix its pose well enough to begin with
constexpr std::uint64_t kFewestBoards = 2;  // one board gives it, and another one contradicts a wrong reading
constexpr std::size_t kMostBoards = 100;    // of a pair: each one's readings are tried on all
constexpr double kMisread_px = 50.0;
constexpr double kWideAngle_rad = 0.35;  // from 20 degrees between two rays on, more helps little
constexpr double kPlanarShare = 0.95;

double median(std::vector<double> values) {
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

/// The points of one tick that two cameras share.
PairTick common_points(const SampleTick& tick, const Sighting* first, const PlaneSightings& seen,
                       std::uint32_t a, std::uint32_t b) {
  PairTick pair;
  pair.tick = tick.tick;
  for (const Sighting& in_a : tick.sightings) {
    if (in_a.camera != a) continue;
    for (const Sighting& in_b : tick.sightings) {
      if (in_b.camera != b || in_b.point != in_a.point) continue;
      const auto& plane_a = seen[static_cast<std::size_t>(&in_a - first)];
      const auto& plane_b = seen[static_cast<std::size_t>(&in_b - first)];
      if (!plane_a || !plane_b) continue;
      pair.points.push_back(in_a.point);
      pair.a.push_back(*plane_a);
      pair.b.push_back(*plane_b);
    }
  }
  return pair;
}

/// Metres that the unit of a pair's translation stands for, from a wand's longest distance.
std::optional<double> scale_of(const RelativePose& pose, const std::vector<PairTick>& ticks,
                               const Target& target) {
  const auto last = static_cast<std::uint32_t>(target.points_in_target.size() - 1);
  const double length_m = (target.points_in_target[last] - target.points_in_target[0]).norm();
  std::vector<double> scales;
  for (std::size_t t = 0; t < ticks.size(); ++t) {
    const PairTick& tick = ticks[t];
    std::optional<Eigen::Vector3d> ends[2];
    for (std::size_t i = 0; i < tick.points.size(); ++i) {
      if (tick.points[i] != 0 && tick.points[i] != last) continue;
      const std::size_t j = pose.swapped[t] != 0 ? 1 - i : i;
      ends[tick.points[i] == 0 ? 0 : 1] = meeting_point(pose.b_from_a, tick.a[i], tick.b[j]);
    }
    if (ends[0] && ends[1] && (*ends[1] - *ends[0]).norm() > 0.0)
      scales.push_back(length_m / (*ends[1] - *ends[0]).norm());
  }
  if (scales.size() < kFewestTicks) return std::nullopt;
  return median(std::move(scales));
}

/// One camera's view of a board.
struct Board {
  std::vector<Eigen::Vector3d> points;  // in the target
  std::vector<Eigen::Vector2d> pixels;
  std::vector<TargetPose> readings;
};

class Start {
 public:
  Start(const SampleSet& samples, const PlaneSightings& seen, const std::vector<CameraCalibration>& cameras)
      : samples_(samples), seen_(seen), cameras_(cameras), ticks_(ticks_of(samples)) {}

  RigStart run() {
    if (samples_.target.kind == TargetKind::Board) find_boards();
    for (std::uint32_t a = 0; a < cameras_.size(); ++a)
      for (std::uint32_t b = a + 1; b < cameras_.size(); ++b) add_pair(a, b);
    join();
    RigStart start;
    const Pose world_from_root = placed_[0]->inverse();
    for (const auto& pose : placed_) start.camera_from_world.push_back(*pose * world_from_root);
    start.pairs = std::move(pairs_);
    return start;
  }

 private:
  const Sighting* first() const noexcept { return samples_.sightings.data(); }

  void add_pair(std::uint32_t a, std::uint32_t b) {
    CameraPair pair;
    pair.a = a, pair.b = b;
    if (samples_.target.kind == TargetKind::Board) {
      from_boards(pair);
    } else {
      from_points(pair);
    }
    if (pair.ticks > 0) pairs_.push_back(std::move(pair));
  }

  void from_points(CameraPair& pair) {
    std::vector<PairTick> common;
    for (const SampleTick& tick : ticks_) {
      PairTick shared = common_points(tick, first(), seen_, pair.a, pair.b);
      if (!shared.points.empty()) common.push_back(std::move(shared));
    }
    pair.ticks = common.size();
    if (common.size() < kFewestTicks) return;
    RelativePoseOptions options;
    options.ends_alike = ends_alike(samples_.target);
    const auto pose = relative_pose(common, options);
    if (!pose) return;
    pair.planar = pose->planar_share > kPlanarShare;
    if (pair.planar) return;
    Pose b_from_a = pose->b_from_a;
    if (samples_.target.kind == TargetKind::Wand) {
      const auto scale = scale_of(*pose, common, samples_.target);
      if (!scale) return;
      b_from_a.translation *= *scale;
    }
    pair.b_from_a = b_from_a;
    pair.weight = static_cast<double>(pose->inliers) * std::min(1.0, pose->median_angle_rad / kWideAngle_rad);
  }

  void find_boards() {
    for (std::size_t t = 0; t < ticks_.size(); ++t) {
      const std::span<const Sighting> all = ticks_[t].sightings;
      for (std::size_t begin = 0, end = 0; begin < all.size(); begin = end) {
        while (end < all.size() && all[end].camera == all[begin].camera) ++end;
        Board board;
        for (const Sighting& s : all.subspan(begin, end - begin)) {
          board.points.push_back(samples_.target.points_in_target[s.point]);
          board.pixels.push_back(s.pixel);
        }
        board.readings = target_poses(cameras_[all[begin].camera], board.points, board.pixels);
        if (!board.readings.empty()) boards_[{t, all[begin].camera}] = std::move(board);
      }
    }
  }

  /// Each board that both see gives the pose anew, small ones in several readings: the one that puts all
  /// boards best where the other camera saw them is taken.
  void from_boards(CameraPair& pair) {
    std::vector<std::pair<const Board*, const Board*>> shared;
    for (std::size_t t = 0; t < ticks_.size(); ++t) {
      const auto a = boards_.find({t, pair.a}), b = boards_.find({t, pair.b});
      if (a != boards_.end() && b != boards_.end()) shared.emplace_back(&a->second, &b->second);
    }
    pair.ticks = shared.size();
    if (pair.ticks < kFewestBoards) return;
    const std::size_t step = (shared.size() + kMostBoards - 1) / kMostBoards;  // evenly over time
    double least = std::numeric_limits<double>::infinity();
    for (std::size_t i = 0; i < shared.size(); i += step) {
      for (const TargetPose& in_a : shared[i].first->readings) {
        for (const TargetPose& in_b : shared[i].second->readings) {
          const Pose b_from_a = in_b.camera_from_target * in_a.camera_from_target.inverse();
          double misfit = 0.0;
          for (std::size_t k = 0; k < shared.size(); k += step)
            misfit += misfit_px(*shared[k].first, *shared[k].second, pair.b, b_from_a);
          if (misfit < least) least = misfit, pair.b_from_a = b_from_a;
        }
      }
    }
    pair.weight = static_cast<double>(pair.ticks);
  }

  /// How far the corners are from where b should see a's board, in its best reading, up to a limit: of boards
  /// that were misread no more can be learnt.
  double misfit_px(const Board& in_a, const Board& in_b, std::uint32_t b, const Pose& b_from_a) const {
    double least = kMisread_px;
    const Intrinsics intrinsics = intrinsics_of(cameras_[b]);
    for (const TargetPose& reading : in_a.readings) {
      const Pose b_from_target = b_from_a * reading.camera_from_target;
      double sum = 0.0;
      for (std::size_t i = 0; i < in_b.points.size(); ++i) {
        PredictedSighting seen;
        const bool there = predict_sighting(intrinsics.data(), b_from_target * in_b.points[i], 0.0, seen);
        sum += there ? (seen.pixel - in_b.pixels[i]).norm() : kMisread_px;
      }
      least = std::min(least, sum / static_cast<double>(in_b.points.size()));
    }
    return least;
  }

  void join() {
    placed_.assign(cameras_.size(), std::nullopt);
    const auto strongest =
        std::max_element(pairs_.begin(), pairs_.end(),
                         [](const CameraPair& x, const CameraPair& y) { return x.weight < y.weight; });
    if (strongest == pairs_.end() || !strongest->b_from_a) fail_unjoined();
    placed_[strongest->a] = Pose{};
    placed_[strongest->b] = *strongest->b_from_a;
    while (place_next()) {
    }
    if (!std::all_of(placed_.begin(), placed_.end(), [](const auto& pose) { return pose.has_value(); }))
      fail_unjoined();
  }

  /// Puts the camera in place whose pair with a placed one is strongest; false if there is none left.
  bool place_next() {
    std::vector<const CameraPair*> open;
    for (const CameraPair& pair : pairs_)
      if (pair.b_from_a && placed_[pair.a].has_value() != placed_[pair.b].has_value()) open.push_back(&pair);
    std::sort(open.begin(), open.end(),
              [](const CameraPair* x, const CameraPair* y) { return x->weight > y->weight; });
    for (const CameraPair* pair : open) {
      const bool forward = placed_[pair->a].has_value();
      const std::uint32_t from = forward ? pair->a : pair->b, to = forward ? pair->b : pair->a;
      Pose to_from_from = forward ? *pair->b_from_a : pair->b_from_a->inverse();
      if (samples_.target.kind == TargetKind::Marker) {
        const auto scale = scale_by_others(from, to, to_from_from);
        if (!scale) continue;
        to_from_from.translation *= *scale;
      }
      placed_[to] = to_from_from * *placed_[from];
      return true;
    }
    return false;
  }

  /// Of a lone marker: where a camera placed already saw it together with this pair, its distance tells the
  /// scale.
  std::optional<double> scale_by_others(std::uint32_t from, std::uint32_t to,
                                        const Pose& to_from_from) const {
    std::vector<double> scales;
    for (const SampleTick& tick : ticks_) {
      const PairTick pair = common_points(tick, first(), seen_, from, to);
      if (pair.points.empty()) continue;
      const auto unscaled = meeting_point(to_from_from, pair.a[0], pair.b[0]);
      if (!unscaled) continue;
      for (std::uint32_t other = 0; other < cameras_.size(); ++other) {
        if (other == from || !placed_[other]) continue;
        const PairTick known = common_points(tick, first(), seen_, from, other);
        if (known.points.empty()) continue;
        const auto scaled = meeting_point(*placed_[other] * placed_[from]->inverse(), known.a[0], known.b[0]);
        if (scaled) scales.push_back(scaled->norm() / unscaled->norm());
      }
    }
    if (scales.size() < kFewestTicks) return std::nullopt;
    return median(std::move(scales));
  }

  [[noreturn]] void fail_unjoined() const {
    const bool any =
        std::any_of(placed_.begin(), placed_.end(), [](const auto& pose) { return pose.has_value(); });
    const bool planar =
        std::any_of(pairs_.begin(), pairs_.end(), [](const CameraPair& pair) { return pair.planar; });
    if (!any && planar) {
      throw Error(
          "all samples lie in one plane, from which the cameras' places cannot be computed: move the target "
          "through the depth of the volume, high and low, near and far");
    }
    std::string text;
    for (std::uint32_t c = 0; c < cameras_.size(); ++c) {
      if (placed_[c]) continue;
      text += (text.empty() ? "" : "\n") + cameras_[c].name +
              " cannot be joined to the other cameras: " + reason(c);
    }
    throw Error(text);
  }

  std::string reason(std::uint32_t camera) const {
    // With the rig if there is one, else with anybody.
    const bool rig = std::any_of(placed_.begin(), placed_.end(), [](const auto& p) { return p.has_value(); });
    const CameraPair *best = nullptr, *outside = nullptr;
    for (const CameraPair& pair : pairs_) {
      if (pair.a != camera && pair.b != camera) continue;
      const CameraPair*& most = rig && !placed_[pair.a] && !placed_[pair.b] ? outside : best;
      if (most == nullptr || pair.ticks > most->ticks) most = &pair;
    }
    if (best == nullptr && outside != nullptr) {
      return "it saw the target together with " +
             cameras_[outside->a == camera ? outside->b : outside->a].name +
             ", but neither with one of the others. Move the target where both groups see it";
    }
    if (best == nullptr)
      return "it never saw the target at the same time as another one. Move the target where it and a "
             "neighbour see it";
    const std::string& other = cameras_[best->a == camera ? best->b : best->a].name;
    const std::string ticks = std::to_string(best->ticks);
    const bool board = samples_.target.kind == TargetKind::Board;
    const std::uint64_t fewest = board ? kFewestBoards : kFewestTicks;
    if (best->ticks < fewest) {
      return "the most that it saw together with another one are " + ticks + " samples with " + other +
             ", and " + std::to_string(fewest) + " are needed";
    }
    if (best->planar)
      return "all " + ticks + " samples that it shares with " + other +
             " lie in one plane: move the target through the depth of the volume";
    if (!best->b_from_a)
      return "its " + ticks + " samples shared with " + other +
             " contradict each other: are the frames of both of the same moment, the lenses those of the "
             "intrinsics, and "
             "is nothing else bright in view?";
    return "no sample was seen by it, " + other +
           " and a third camera together, which is what tells the scale of a single marker. Use a wand, or "
           "move the "
           "marker where three cameras see it";
  }

  const SampleSet& samples_;
  const PlaneSightings& seen_;
  const std::vector<CameraCalibration>& cameras_;
  std::vector<SampleTick> ticks_;
  std::map<std::pair<std::size_t, std::uint32_t>, Board> boards_;  // by tick (index) and camera
  std::vector<CameraPair> pairs_;
  std::vector<std::optional<Pose>> placed_;  // camera_from_root
};

}  // namespace

bool ends_alike(const Target& target) {
  return target.kind == TargetKind::Wand && target.points_in_target.size() == 2;
}

PlaneSightings undistorted(const SampleSet& samples, const std::vector<CameraCalibration>& cameras) {
  std::vector<Camera> lenses(cameras.begin(), cameras.end());
  PlaneSightings seen;
  seen.reserve(samples.sightings.size());
  for (const Sighting& s : samples.sightings) seen.push_back(lenses[s.camera].undistort(s.pixel));
  return seen;
}

RigStart start_rig(const SampleSet& samples, const PlaneSightings& seen,
                   const std::vector<CameraCalibration>& cameras) {
  return Start(samples, seen, cameras).run();
}

void match_ends(SampleSet& samples, PlaneSightings& seen, const std::vector<Pose>& camera_from_world) {
  if (!ends_alike(samples.target)) return;
  // Distance of two rays, as an angle: how far they are from meeting.
  const auto apart = [&](const Pose& b_from_a, const Eigen::Vector2d& a, const Eigen::Vector2d& b) {
    const Eigen::Vector3d normal = b_from_a.translation.cross(b_from_a.rotation * a.homogeneous());
    return std::abs(normal.normalized().dot(b.homogeneous().normalized()));
  };
  for (std::size_t begin = 0, end = 0; begin < samples.sightings.size(); begin = end) {
    while (end < samples.sightings.size() && samples.sightings[end].tick == samples.sightings[begin].tick)
      ++end;
    // Whole sightings of the wand, camera after camera: the first is the reference.
    std::vector<std::size_t> wands;
    for (std::size_t i = begin; i + 1 < end; ++i) {
      if (samples.sightings[i].camera == samples.sightings[i + 1].camera && seen[i] && seen[i + 1])
        wands.push_back(i++);
    }
    for (std::size_t w = 1; w < wands.size(); ++w) {
      double same = 0.0, swapped = 0.0;
      const std::size_t i = wands[w];
      for (std::size_t k = 0; k < w; ++k) {
        const std::size_t j = wands[k];
        const Pose b_from_a = camera_from_world[samples.sightings[i].camera] *
                              camera_from_world[samples.sightings[j].camera].inverse();
        same += apart(b_from_a, *seen[j], *seen[i]) + apart(b_from_a, *seen[j + 1], *seen[i + 1]);
        swapped += apart(b_from_a, *seen[j], *seen[i + 1]) + apart(b_from_a, *seen[j + 1], *seen[i]);
      }
      if (swapped < same) {
        std::swap(samples.sightings[i].pixel, samples.sightings[i + 1].pixel);
        std::swap(seen[i], seen[i + 1]);
      }
    }
  }
}

}  // namespace glint
