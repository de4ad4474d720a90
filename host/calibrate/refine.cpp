// SPDX-License-Identifier: MIT
#include "host/calibrate/refine.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>

#include <Eigen/Geometry>

#include "host/base/error.hpp"
#include "host/calibrate/bundle.hpp"
#include "host/calibrate/evaluate.hpp"
#include "host/geometry/triangulate.hpp"

namespace glint {
namespace {

constexpr std::size_t kFewestMarkers = 500;
constexpr std::size_t kFewestOfCamera = 100;
constexpr double kWorthIt = 0.98;  // of the held-out median: less of a gain is chance
constexpr double kHarm = 1.05;     // of one camera's
// How much the cameras' orientations count beside their positions in the alignment, relative to the size of
// the rig: just enough to fix what positions on a line leave open.
constexpr double kOrientationWeight = 0.01;

/// In the frame of the first camera, as an adjustment wants it whose scale is free.
Bundle bundle_of(const Calibration& calibration, const SampleSet& samples) {
  Bundle bundle;
  bundle.target = samples.target;
  const Pose world_from_first = calibration.cameras.front().world_from_camera;
  const Pose first_from_world = world_from_first.inverse();
  std::vector<Camera> cameras;
  for (const CameraCalibration& c : calibration.cameras) {
    cameras.emplace_back(c);
    bundle.cameras.push_back({intrinsics_of(c), {}, c.world_from_camera.inverse() * world_from_first, false});
  }
  TriangulateOptions options;
  options.marker_radius_m = samples.target.marker_radius_m;
  const std::vector<SampleTick> ticks = ticks_of(samples);
  for (std::size_t t = 0; t < ticks.size(); ++t) {
    if (held_out(t)) continue;
    std::vector<Observation> views;
    std::vector<BundleSighting> seen;
    for (const Sighting& s : ticks[t].sightings) {
      const auto plane = cameras[s.camera].undistort(s.pixel);
      if (!plane) continue;
      views.push_back({&cameras[s.camera], *plane, Eigen::Matrix2d::Identity()});
      seen.push_back({s.camera, static_cast<std::uint32_t>(bundle.ticks.size()), 0, s.pixel});
    }
    const auto found = triangulate(views, options);
    if (!found) continue;
    bundle.ticks.push_back({{}, first_from_world * found->position_in_world});
    bundle.sightings.insert(bundle.sightings.end(), seen.begin(), seen.end());
  }
  return bundle;
}

void check_enough(const Calibration& calibration, const Bundle& bundle) {
  if (bundle.ticks.size() < kFewestMarkers) {
    throw Error("only " + std::to_string(bundle.ticks.size()) +
                " markers were seen by three cameras or more; " + std::to_string(kFewestMarkers) +
                " are needed to refine a calibration");
  }
  for (std::uint32_t c = 0; c < calibration.cameras.size(); ++c) {
    const auto count = std::count_if(bundle.sightings.begin(), bundle.sightings.end(),
                                     [c](const BundleSighting& s) { return s.camera == c; });
    if (count < static_cast<std::ptrdiff_t>(kFewestOfCamera)) {
      throw Error(calibration.cameras[c].name + " saw only " + std::to_string(count) + " of the markers; " +
                  std::to_string(kFewestOfCamera) + " are needed of each camera");
    }
  }
}

/// The adjusted cameras, put back where the rig was, at its size.
Calibration put_back(const Calibration& before, const Bundle& bundle, Refinement& refinement) {
  const auto count = static_cast<Eigen::Index>(before.cameras.size());
  std::vector<Pose> poses;
  double extent_m = 0.0;
  for (const BundleCamera& camera : bundle.cameras) {
    poses.push_back(camera.camera_from_world.inverse());
    extent_m = std::max(extent_m, poses.back().translation.norm());
  }
  // Of each camera its place, and a little way along its three axes.
  Eigen::Matrix<double, 3, 4> marks = Eigen::Matrix<double, 3, 4>::Zero();
  marks.rightCols<3>().diagonal().setConstant(kOrientationWeight * extent_m);
  Eigen::Matrix3Xd from(3, 4 * count), to(3, 4 * count);
  for (Eigen::Index i = 0; i < 4 * count; ++i) {
    const auto c = static_cast<std::size_t>(i / 4);
    from.col(i) = poses[c] * marks.col(i % 4);
    to.col(i) = before.cameras[c].world_from_camera * marks.col(i % 4);
  }
  const Eigen::Matrix4d similarity = Eigen::umeyama(from, to, true);
  const double scale = std::cbrt(similarity.topLeftCorner<3, 3>().determinant());
  const Pose turn{Eigen::Quaterniond(Eigen::Matrix3d(similarity.topLeftCorner<3, 3>() / scale)),
                  similarity.topRightCorner<3, 1>()};
  Calibration after = before;
  for (std::size_t c = 0; c < poses.size(); ++c) {
    Pose& pose = after.cameras[c].world_from_camera;
    poses[c].translation *= scale;
    const Pose placed = turn * poses[c];
    refinement.worst_shift_m =
        std::max(refinement.worst_shift_m, (placed.translation - pose.translation).norm());
    refinement.worst_turn_rad =
        std::max(refinement.worst_turn_rad, placed.rotation.angularDistance(pose.rotation));
    pose = placed;
  }
  return after;
}

void judge_refinement(Refinement& r) {
  std::vector<double> before, after;
  r.better = true;
  char text[160];
  for (std::size_t c = 0; c < r.before.cameras.size(); ++c) {
    const CameraQuality &was = r.before.cameras[c], &is = r.after.cameras[c];
    for (const PixelResidual& p : was.residuals)
      if (p.held_out) before.push_back(p.residual_px.norm());
    for (const PixelResidual& p : is.residuals)
      if (p.held_out) after.push_back(p.residual_px.norm());
    if (is.held_out_px.p50 <= kHarm * was.held_out_px.p50) continue;
    r.better = false;
    std::snprintf(text, sizeof text, "the held-out error of %s would rise from %.3f to %.3f px",
                  was.name.c_str(), was.held_out_px.p50, is.held_out_px.p50);
    r.reason = text;
  }
  const double was_px = summarise(before).p50, is_px = summarise(after).p50;
  if (!r.better) return;
  r.better = is_px <= kWorthIt * was_px;
  std::snprintf(text, sizeof text, "the median held-out error %s from %.4f to %.4f px",
                r.better ? "falls" : "goes", was_px, is_px);
  r.reason = text;
}

}  // namespace

TrackedSamples::TrackedSamples(std::vector<SampleCamera> cameras, double marker_radius_m) {
  samples_.target = marker_target(marker_radius_m);
  samples_.cameras = std::move(cameras);
}

void TrackedSamples::add(std::span<const Sighting> sightings) {
  if (sightings.size() < 3) return;
  begins_.push_back(samples_.sightings.size());
  for (Sighting s : sightings) {
    s.point = 0;
    samples_.sightings.push_back(s);
  }
}

SampleSet TrackedSamples::take(std::size_t most) {
  SampleSet thinned;
  thinned.target = samples_.target;
  thinned.cameras = samples_.cameras;
  const std::size_t wanted = std::min(most, begins_.size());
  begins_.push_back(samples_.sightings.size());
  // Each marker gets a tick of its own, in the order of time, so that blocks that are held out are of another
  // time.
  for (std::size_t k = 0; k < wanted; ++k) {
    const std::size_t marker = k * (begins_.size() - 1) / wanted;
    for (std::size_t i = begins_[marker]; i < begins_[marker + 1]; ++i) {
      thinned.sightings.push_back(samples_.sightings[i]);
      thinned.sightings.back().tick = k;
    }
  }
  samples_.sightings.clear();
  begins_.clear();
  put_in_order(thinned);
  return thinned;
}

Refinement refine(const Calibration& calibration, const SampleSet& samples) {
  Bundle bundle = bundle_of(calibration, samples);
  check_enough(calibration, bundle);
  BundleOptions options;
  options.sigma_px =
      0.1;  // beyond three of these a sighting counts less; wrong matches are several pixels off
  options.scale_known = false;
  adjust(bundle, options);
  Refinement refinement;
  refinement.calibration = put_back(calibration, bundle, refinement);
  refinement.before = evaluate(calibration, samples, true);
  refinement.after = evaluate(refinement.calibration, samples, true);
  judge_refinement(refinement);
  for (std::size_t c = 0; c < refinement.calibration.cameras.size(); ++c)
    refinement.calibration.cameras[c].rms_px = refinement.after.cameras[c].held_out_px.rms;
  return refinement;
}

}  // namespace glint
