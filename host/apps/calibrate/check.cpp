// SPDX-License-Identifier: MIT
// `glint calibrate check`: ten seconds with the wand, then green or red for each camera.
#include <cmath>
#include <cstdio>
#include <memory>

#include "host/apps/calibrate/commands.hpp"
#include "host/apps/calibrate/wand_samples.hpp"
#include "host/apps/health_text.hpp"
#include "host/base/error.hpp"
#include "host/calibrate/evaluate.hpp"
#include "host/calibrate/rig_start.hpp"
#include "host/config/rig.hpp"
#include "host/pipeline/track_step.hpp"

namespace glint::apps {
namespace {

struct CheckArguments {
  RunArguments run;
  std::vector<double> wand_m;
  double marker_radius_m = -1.0, length_tolerance_m = 0.001;
  bool quiet = false;
};

/// True if all is green.
bool print_cameras(const HealthReport& health, const Calibration& calibration) {
  std::vector<std::string> names;
  for (const CameraCalibration& camera : calibration.cameras) names.push_back(camera.name);
  bool good = true;
  for (std::size_t c = 0; c < names.size(); ++c) {
    const CameraReport& camera = health.cameras[c];
    good = good && camera.green();
    std::printf("%s %-10s %s; residual %.3f px (%.3f expected), %llu of %llu sightings agree\n",
                camera.green() ? "green" : "RED  ", names[c].c_str(), state_text(camera.state, names).c_str(),
                camera.residual_px, camera.expected_px, static_cast<unsigned long long>(camera.agreed),
                static_cast<unsigned long long>(camera.compared));
  }
  return good;
}

bool print_lengths(const CalibrationQuality& quality, double tolerance_m) {
  bool good = !quality.lengths.empty();
  for (const LengthQuality& length : quality.lengths) {
    const bool within =
        std::abs(length.mean_m - length.true_m) <= tolerance_m && length.error_m.p95 <= 3.0 * tolerance_m;
    good = good && within;
    std::printf("%s length %.4f m, measured %llu times: mean error %+.3f mm, sd %.3f mm, p95 %.3f mm\n",
                within ? "green" : "RED  ", length.true_m,
                static_cast<unsigned long long>(length.error_m.count), 1e3 * (length.mean_m - length.true_m),
                1e3 * length.sd_m, 1e3 * length.error_m.p95);
  }
  if (quality.lengths.empty()) std::printf("RED   the wand was never seen whole by two cameras\n");
  return good;
}

void run(const CheckArguments& a) {
  if (a.run.rig_file.empty() && a.run.source != "sim")
    throw UsageError("--rig FILE is needed: the calibration to check");
  RunArguments arguments = a.run;
  if (!arguments.seconds && arguments.max_ticks == 0) arguments.seconds = 10.0;
  const double radius_m = sphere_radius_m(a.marker_radius_m, a.run);
  std::unique_ptr<TrackStep> track;  // for what it tells of the cameras
  Rig rig;
  WandSamples taken = collect_wand_samples(
      arguments, wand_target(a.wand_m, radius_m), a.quiet,
      [&](const Rig& opened) {
        rig = opened;
        track = std::make_unique<TrackStep>(rig.calibration, rig.match, rig.track);
      },
      [&](const TickBlobs& tick) {
        track->take(tick);
        track->watch(tick);
      });
  if (!taken.failure.empty()) throw Error(taken.failure);
  PlaneSightings seen = undistorted(taken.samples, taken.lenses);
  std::vector<Pose> poses;
  for (const CameraCalibration& camera : taken.lenses) poses.push_back(camera.world_from_camera.inverse());
  match_ends(taken.samples, seen, poses);
  const bool cameras_good = print_cameras(track->health().report(), rig.calibration);
  const bool lengths_good =
      print_lengths(evaluate(rig.calibration, taken.samples, false), a.length_tolerance_m);
  if (!cameras_good || !lengths_good) throw Error("the calibration does not hold: see what is red above");
}

}  // namespace

void add_calibrate_check(CLI::App& calibrate) {
  CLI::App* command =
      calibrate.add_subcommand("check", "Wave the wand for ten seconds: does the calibration still hold?");
  const auto a = std::make_shared<CheckArguments>();
  add_run_options(*command, a->run, "sim, v4l2:[DEVICE,...], images:LOCATION or blobs:FOLDER");
  command
      ->add_option("--wand", a->wand_m,
                   "places of its two or three markers, metres from the first: 0,0.13,0.39")
      ->delimiter(',')
      ->required();
  command->add_option("--radius", a->marker_radius_m, "of the spheres, metres (default: the rig file's)");
  command
      ->add_option("--tolerance", a->length_tolerance_m,
                   "of the wand's mean lengths, metres; three times that for 95 % of all")
      ->capture_default_str()
      ->check(CLI::PositiveNumber);
  command->add_flag("--quiet", a->quiet, "no status line, no messages");
  command->callback([a] { run(*a); });
}

}  // namespace glint::apps
