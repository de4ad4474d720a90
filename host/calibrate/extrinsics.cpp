// SPDX-License-Identifier: MIT
#include "host/calibrate/extrinsics.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>

#include "host/base/error.hpp"
#include "host/calibrate/evaluate.hpp"
#include "host/calibrate/pnp.hpp"
#include "host/calibrate/uncertainty.hpp"
#include "host/geometry/triangulate.hpp"

namespace glint {
namespace {

constexpr std::size_t kFewestTicks = 40;  // of a wand or a marker; below that a held-out fifth says nothing
constexpr std::size_t kFewestBoards = 5;
constexpr double kOutlier = 6.0;  // standard deviations: of 100,000 good sightings none is that far off
constexpr double kLeastSigma_px =
    0.02;  // no detector is better, so nothing is thrown out for less than 0.12 px

void check_cameras(const SampleSet& samples, const std::vector<CameraCalibration>& cameras,
                   const ExtrinsicsOptions& options) {
  if (samples.cameras.size() != cameras.size())
    throw Error("the samples are of " + std::to_string(samples.cameras.size()) +
                " cameras, the intrinsics of " + std::to_string(cameras.size()));
  for (std::size_t c = 0; c < cameras.size(); ++c) {
    const SampleCamera& s = samples.cameras[c];
    const CameraCalibration& k = cameras[c];
    if (s.width_px != k.width_px || s.height_px != k.height_px) {
      throw Error(s.name + ": its images are " + std::to_string(s.width_px) + "x" +
                  std::to_string(s.height_px) + ", but its intrinsics are for " + std::to_string(k.width_px) +
                  "x" + std::to_string(k.height_px) + ": calibrate the intrinsics at the size that is used");
    }
  }
  if (cameras.size() < 2) throw Error("extrinsics need two cameras at least; the samples are of one");
  const bool marker = samples.target.kind == TargetKind::Marker;
  if (marker && options.only.empty() && !options.camera_distance)
    throw Error("a single marker tells no scale: give the distance of two cameras, or use a wand");
  if (options.camera_distance) {
    const KnownCameraDistance& known = *options.camera_distance;
    if (!marker) throw Error("the target itself gives the scale: a camera distance would contradict it");
    if (!options.only.empty())
      throw Error("the cameras that stay give the scale: a camera distance would contradict them");
    if (known.a == known.b || known.a >= cameras.size() || known.b >= cameras.size() ||
        !(known.distance_m > 0.0) || !std::isfinite(known.distance_m))
      throw Error("the known distance must be more than 0 m and between two different cameras");
  }
}

void give_unknown_sd(BundleCamera& camera, const CameraCalibration& known) {
  camera.intrinsics_sd = known.intrinsics_sd;
  if (std::any_of(known.intrinsics_sd.begin(), known.intrinsics_sd.end(), [](double sd) { return sd > 0.0; }))
    return;
  const UnknownIntrinsicsSd sd;
  const double width = known.width_px;
  camera.intrinsics_sd = {sd.focal * known.fx_px,
                          sd.focal * known.fy_px,
                          sd.centre * width,
                          sd.centre * width,
                          sd.k1,
                          sd.k2,
                          sd.p,
                          sd.p,
                          sd.k3};
}

class Solver {
 public:
  Solver(const SampleSet& samples, const std::vector<CameraCalibration>& cameras,
         const ExtrinsicsOptions& options)
      : options_(options), samples_(samples), cameras_(cameras) {
    check_cameras(samples, cameras, options);
    seen_ = undistorted(samples_, cameras_);
    take_training_ticks();
  }

  ExtrinsicsResult run() {
    if (options_.only.empty()) {
      RigStart start = start_rig(training_, training_seen_, cameras_);
      poses_ = std::move(start.camera_from_world);
      result_.pairs = std::move(start.pairs);
    } else {
      for (const CameraCalibration& camera : cameras_) poses_.push_back(camera.world_from_camera.inverse());
      place_again();
    }
    match_ends(training_, training_seen_, poses_);
    match_ends(samples_, seen_, poses_);
    make_bundle();
    adjust_without_outliers();
    finish();
    return std::move(result_);
  }

 private:
  void take_training_ticks() {
    training_.target = samples_.target;
    training_.cameras = samples_.cameras;
    const std::vector<SampleTick> ticks = ticks_of(samples_);
    const bool board = samples_.target.kind == TargetKind::Board;
    const std::size_t fewest = board ? kFewestBoards : kFewestTicks;
    if (ticks.size() < fewest) {
      throw Error("only " + std::to_string(ticks.size()) +
                  (board ? " views of the board" : " samples of the target") + ": " + std::to_string(fewest) +
                  " are needed at the very least, and some hundreds for a good calibration");
    }
    // A handful of boards is too few to keep some back.
    hold_out_ = options_.hold_out && ticks.size() >= kFewestTicks;
    if (options_.hold_out && !hold_out_)
      result_.notes.push_back("too few samples to keep a fifth back: the errors are those of the fit itself");
    for (std::size_t t = 0; t < ticks.size(); ++t) {
      if (hold_out_ && held_out(t)) continue;
      for (const Sighting& s : ticks[t].sightings) {
        place_of_training_.push_back(static_cast<std::size_t>(&s - samples_.sightings.data()));
        training_.sightings.push_back(s);
        training_seen_.push_back(seen_[place_of_training_.back()]);
      }
    }
  }

  /// Cameras of `only`, from points that the others know. Of a wand whose ends look alike its middle is such
  /// a point: near enough to begin with, and the same whichever end is which.
  void place_again() {
    const std::vector<Camera> known(cameras_.begin(), cameras_.end());
    SampleSet stay = training_;
    std::erase_if(stay.sightings, [&](const Sighting& s) {
      return std::find(options_.only.begin(), options_.only.end(), s.camera) != options_.only.end();
    });
    PlaneSightings stay_seen = undistorted(stay, cameras_);
    match_ends(stay, stay_seen, poses_);
    std::map<std::pair<std::uint64_t, std::uint32_t>, Eigen::Vector3d> places;  // by tick and point
    for (const SampleTick& tick : ticks_of(stay)) {
      for (std::uint32_t point = 0; point < stay.target.points_in_target.size(); ++point) {
        std::vector<Observation> views;
        for (const Sighting& s : tick.sightings) {
          const auto& plane = stay_seen[static_cast<std::size_t>(&s - stay.sightings.data())];
          if (s.point == point && plane)
            views.push_back({&known[s.camera], *plane, Eigen::Matrix2d::Identity()});
        }
        if (const auto found = triangulate(views, {})) places[{tick.tick, point}] = found->position_in_world;
      }
    }
    for (const std::uint32_t camera : options_.only) {
      std::vector<Eigen::Vector3d> points;
      std::vector<Eigen::Vector2d> pixels;
      for (std::size_t i = 0; i < training_.sightings.size(); ++i) {
        const Sighting& s = training_.sightings[i];
        const auto place = places.find({s.tick, s.point});
        if (s.camera != camera || place == places.end()) continue;
        if (!ends_alike(training_.target)) {
          points.push_back(place->second);
          pixels.push_back(s.pixel);
          continue;
        }
        const auto other = places.find({s.tick, 1});
        if (s.point != 0 || other == places.end() || i + 1 == training_.sightings.size()) continue;
        const Sighting& next = training_.sightings[i + 1];
        if (next.tick != s.tick || next.camera != camera) continue;
        points.push_back(0.5 * (place->second + other->second));
        pixels.push_back(0.5 * (s.pixel + next.pixel));
      }
      if (points.size() < kFewestTicks) {
        throw Error(cameras_[camera].name + ": only " + std::to_string(points.size()) +
                    " samples are known from two other cameras: move the target where it and they see it");
      }
      const auto pose = camera_from_target(cameras_[camera], points, pixels);
      if (!pose) throw Error(cameras_[camera].name + ": what it saw fits no place that it could stand at");
      poses_[camera] = *pose;
    }
  }

  void make_bundle() {
    bundle_.target = training_.target;
    for (std::uint32_t c = 0; c < cameras_.size(); ++c) {
      BundleCamera camera;
      camera.intrinsics = intrinsics_of(cameras_[c]);
      give_unknown_sd(camera, cameras_[c]);
      camera.camera_from_world = poses_[c];
      camera.pose_fixed = !options_.only.empty() &&
                          std::find(options_.only.begin(), options_.only.end(), c) == options_.only.end();
      if (camera.pose_fixed) camera.intrinsics_sd = {};
      bundle_.cameras.push_back(camera);
    }
    for (const SampleTick& tick : ticks_of(training_)) {
      if (training_.target.kind == TargetKind::Board) {
        add_board(tick);
      } else {
        add_points(tick);
      }
    }
  }

  Camera camera_at(std::uint32_t c) const {
    CameraCalibration camera = cameras_[c];
    camera.world_from_camera = poses_[c].inverse();
    return Camera(camera);
  }

  void add_sighting(const Sighting& s) {
    place_of_bundle_.push_back(place_of_training_[static_cast<std::size_t>(&s - training_.sightings.data())]);
    bundle_.sightings.push_back(
        {s.camera, static_cast<std::uint32_t>(bundle_.ticks.size()), s.point, s.pixel});
  }

  /// Of a wand only if all its markers can be placed: its lengths bind them together.
  void add_points(const SampleTick& tick) {
    if (lenses_.empty())
      for (std::uint32_t c = 0; c < cameras_.size(); ++c) lenses_.push_back(camera_at(c));
    const std::size_t count = training_.target.points_in_target.size();
    BundleTick place;
    place.points_in_world.resize(3, static_cast<Eigen::Index>(count));
    std::vector<const Sighting*> used;
    for (std::uint32_t point = 0; point < count; ++point) {
      std::vector<Observation> views;
      for (const Sighting& s : tick.sightings) {
        const auto& plane = training_seen_[static_cast<std::size_t>(&s - training_.sightings.data())];
        if (s.point != point || !plane) continue;
        views.push_back({&lenses_[s.camera], *plane, Eigen::Matrix2d::Identity()});
        used.push_back(&s);
      }
      const auto found = triangulate(views, {});
      if (!found) return;
      place.points_in_world.col(point) = found->position_in_world;
    }
    for (const Sighting* s : used) add_sighting(*s);
    bundle_.ticks.push_back(std::move(place));
  }

  /// Of a board if two cameras see it; its place is that of the reading that fits all of them best.
  void add_board(const SampleTick& tick) {
    std::map<std::uint32_t, std::vector<const Sighting*>> by_camera;
    for (const Sighting& s : tick.sightings) by_camera[s.camera].push_back(&s);
    if (by_camera.size() < 2) return;
    const std::vector<Eigen::Vector3d>& target = training_.target.points_in_target;
    double least = std::numeric_limits<double>::infinity();
    BundleTick place;
    for (const auto& [camera, sightings] : by_camera) {
      std::vector<Eigen::Vector3d> points;
      std::vector<Eigen::Vector2d> pixels;
      for (const Sighting* s : sightings) points.push_back(target[s->point]), pixels.push_back(s->pixel);
      for (const TargetPose& reading : target_poses(cameras_[camera], points, pixels)) {
        const Pose world_from_target = poses_[camera].inverse() * reading.camera_from_target;
        const double misfit = misfit_of(tick, world_from_target);
        if (misfit < least) least = misfit, place.world_from_target = world_from_target;
      }
    }
    if (!std::isfinite(least)) return;
    for (const Sighting& s : tick.sightings) add_sighting(s);
    bundle_.ticks.push_back(std::move(place));
  }

  double misfit_of(const SampleTick& tick, const Pose& world_from_target) const {
    double sum = 0.0;
    for (const Sighting& s : tick.sightings) {
      PredictedSighting predicted;
      const Eigen::Vector3d point =
          poses_[s.camera] * (world_from_target * training_.target.points_in_target[s.point]);
      if (!predict_sighting(bundle_.cameras[s.camera].intrinsics.data(), point, 0.0, predicted))
        return std::numeric_limits<double>::infinity();
      sum += (predicted.pixel - s.pixel).norm();
    }
    return sum;
  }

  std::vector<double> residuals_px() const {
    std::vector<double> residuals;
    for (const BundleSighting& s : bundle_.sightings) {
      const BundleTick& tick = bundle_.ticks[s.tick];
      const Eigen::Vector3d world =
          bundle_.target.kind == TargetKind::Board
              ? Eigen::Vector3d(tick.world_from_target * bundle_.target.points_in_target[s.point])
              : Eigen::Vector3d(tick.points_in_world.col(s.point));
      const BundleCamera& camera = bundle_.cameras[s.camera];
      PredictedSighting predicted;
      const bool seen = predict_sighting(camera.intrinsics.data(), camera.camera_from_world * world,
                                         bundle_.target.marker_radius_m, predicted);
      residuals.push_back(seen ? (predicted.pixel - s.pixel).norm()
                               : std::numeric_limits<double>::infinity());
    }
    return residuals;
  }

  BundleOptions bundle_options(double sigma_px, bool robust) const {
    BundleOptions options;
    options.sigma_px = sigma_px;
    options.length_sd_m = options_.length_sd_m;
    options.robust = robust;
    options.refine_intrinsics = options_.refine_intrinsics;
    options.scale_known = samples_.target.kind != TargetKind::Marker || !options_.only.empty();
    options.schur = options_.schur;
    return options;
  }

  /// Standard deviation per axis, from the median length of the residuals (of a Rayleigh distribution), as
  /// each sighting's share of the unknowns shrinks it.
  double robust_sigma_px() const {
    std::vector<double> residuals = residuals_px();
    const auto middle = residuals.begin() + static_cast<std::ptrdiff_t>(residuals.size() / 2);
    std::nth_element(residuals.begin(), middle, residuals.end());
    const double per_tick = bundle_.target.kind == TargetKind::Board
                                ? 6.0
                                : 3.0 * static_cast<double>(bundle_.target.points_in_target.size());
    std::size_t ticks = 0;  // with sightings, which stand tick after tick
    for (std::size_t i = 0; i < bundle_.sightings.size(); ++i)
      ticks += i == 0 || bundle_.sightings[i].tick != bundle_.sightings[i - 1].tick;
    const double measured = 2.0 * static_cast<double>(residuals.size());
    const double free = std::max(0.1, 1.0 - per_tick * static_cast<double>(ticks) / measured);
    return std::max(kLeastSigma_px, *middle / std::sqrt(2.0 * std::log(2.0)) / std::sqrt(free));
  }

  void adjust_without_outliers() {
    if (bundle_.sightings.empty())
      throw Error("no sample was seen well by two cameras: nothing to compute the cameras' places from");
    adjust(bundle_, bundle_options(1.0, true));
    adjust(bundle_, bundle_options(robust_sigma_px(), true));
    outlier_.assign(samples_.sightings.size(), 0);
    sigma_px_ = robust_sigma_px();
    drop_outliers();
    result_.adjustment = adjust(bundle_, bundle_options(sigma_px_, false));
    sigma_px_ = robust_sigma_px();
    if (!result_.adjustment.converged)
      result_.notes.push_back("the bundle adjustment stopped before its minimum: " +
                              result_.adjustment.message);
  }

  void drop_outliers() {
    const std::vector<double> residuals = residuals_px();
    std::vector<std::uint8_t> drop(bundle_.sightings.size(), 0);
    for (std::size_t i = 0; i < drop.size(); ++i) drop[i] = residuals[i] > kOutlier * sigma_px_ ? 1 : 0;
    // A marker that is then left with one view would float: its whole tick goes.
    const std::size_t points = bundle_.target.points_in_target.size();
    std::vector<std::uint32_t> views(bundle_.ticks.size() * points, 0);
    std::vector<std::uint8_t> wanted(views.size(), 0);
    for (std::size_t i = 0; i < drop.size(); ++i) {
      const BundleSighting& s = bundle_.sightings[i];
      wanted[s.tick * points + s.point] = 1;
      if (drop[i] == 0) ++views[s.tick * points + s.point];
    }
    std::vector<std::uint8_t> loose(bundle_.ticks.size(), 0);
    const std::uint32_t fewest = bundle_.target.kind == TargetKind::Board ? 0 : 2;
    for (std::size_t i = 0; i < views.size(); ++i)
      if (wanted[i] != 0 && views[i] < fewest) loose[i / points] = 1;
    std::vector<BundleSighting> kept;
    std::uint64_t dropped = 0, ticks = 0;
    for (std::size_t i = 0; i < drop.size(); ++i) {
      if (drop[i] != 0) outlier_[place_of_bundle_[i]] = 1, ++dropped;
      if (drop[i] == 0 && loose[bundle_.sightings[i].tick] == 0) kept.push_back(bundle_.sightings[i]);
    }
    for (const std::uint8_t tick : loose) ticks += tick;
    bundle_.sightings = std::move(kept);
    if (dropped > 0) {
      result_.notes.push_back(std::to_string(dropped) + " sightings more than " +
                              std::to_string(static_cast<int>(kOutlier)) +
                              " standard deviations off were left out of the fit, and with them " +
                              std::to_string(ticks) + " samples that could no longer be placed");
    }
    if (bundle_.sightings.empty()) throw Error("the samples contradict each other: no solution fits them");
    for (std::uint32_t c = 0; c < cameras_.size(); ++c) {
      if (!bundle_.cameras[c].pose_fixed &&
          std::none_of(bundle_.sightings.begin(), bundle_.sightings.end(),
                       [c](const BundleSighting& s) { return s.camera == c; }))
        throw Error(cameras_[c].name +
                    ": none of its sightings could be used: it must see the target together with others");
    }
  }

  void finish() {
    result_.uncertainty = uncertainty_of(bundle_, bundle_options(sigma_px_, false), sigma_px_);
    double scale = 1.0;
    if (options_.camera_distance) {
      const KnownCameraDistance& known = *options_.camera_distance;
      const Eigen::Vector3d a = bundle_.cameras[known.a].camera_from_world.inverse().translation;
      const Eigen::Vector3d b = bundle_.cameras[known.b].camera_from_world.inverse().translation;
      scale = known.distance_m / (b - a).norm();
    }
    for (std::size_t c = 0; c < cameras_.size(); ++c) {
      CameraCalibration camera = cameras_[c];
      set_intrinsics(camera, bundle_.cameras[c].intrinsics);
      camera.world_from_camera = bundle_.cameras[c].camera_from_world.inverse();
      camera.world_from_camera.translation *= scale;
      camera.world_from_camera.translation.array() += 0.0;  // -0 looks odd in a file
      camera.world_from_camera.rotation.coeffs().array() += 0.0;
      result_.calibration.cameras.push_back(std::move(camera));
    }
    if (scale != 1.0) scale_uncertainty(scale);
    result_.timing = timing_of(result_.calibration, samples_);
    if (result_.timing) {
      for (std::string& sentence : timing_sentences(*result_.timing, result_.calibration))
        result_.notes.push_back(std::move(sentence));
    }
    result_.quality = evaluate(result_.calibration, samples_, hold_out_, outlier_);
    result_.samples = std::move(samples_);
    for (std::size_t c = 0; c < cameras_.size(); ++c) {
      const ErrorSummary& fit = result_.quality.cameras[c].fit_px;
      if (fit.count > 0) result_.calibration.cameras[c].rms_px = fit.rms;  // else it stayed, unseen
    }
  }

  void scale_uncertainty(double scale) {
    const Eigen::Index per_camera = result_.uncertainty.intrinsics ? 15 : 6;
    Eigen::MatrixXd& covariance = result_.uncertainty.covariance;
    for (Eigen::Index at = 3; at < covariance.rows(); at += per_camera) {
      covariance.middleRows(at, 3) *= scale;
      covariance.middleCols(at, 3) *= scale;
    }
  }

  const ExtrinsicsOptions& options_;
  SampleSet samples_, training_;
  const std::vector<CameraCalibration>& cameras_;
  PlaneSightings seen_, training_seen_;
  std::vector<std::size_t> place_of_training_;  // in samples_
  std::vector<std::size_t> place_of_bundle_;    // in samples_, of the bundle's first sightings
  std::vector<Pose> poses_;                     // camera_from_world at the start
  std::vector<Camera> lenses_;                  // with those poses
  bool hold_out_ = true;
  Bundle bundle_;
  double sigma_px_ = 1.0;
  std::vector<std::uint8_t> outlier_;
  ExtrinsicsResult result_;
};

}  // namespace

ExtrinsicsResult solve_extrinsics(const SampleSet& samples, const std::vector<CameraCalibration>& cameras,
                                  const ExtrinsicsOptions& options) {
  return Solver(samples, cameras, options).run();
}

}  // namespace glint
