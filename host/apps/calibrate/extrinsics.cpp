// SPDX-License-Identifier: MIT
// `glint calibrate extrinsics`: where the cameras stand, from a wand, a marker or a board moved before them.
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <memory>

#include "host/apps/calibrate/board_samples.hpp"
#include "host/apps/calibrate/commands.hpp"
#include "host/apps/calibrate/known_points.hpp"
#include "host/apps/calibrate/wand_samples.hpp"
#include "host/apps/utc_time.hpp"
#include "host/base/error.hpp"
#include "host/calibrate/calibration_report.hpp"
#include "host/calibrate/extrinsics.hpp"
#include "host/calibrate/ground.hpp"
#include "host/calibrate/sample_points.hpp"
#include "host/config/rig.hpp"

namespace glint::apps {
namespace {

struct ExtrinsicsArguments {
  RunArguments run;
  std::vector<double> wand_m;
  std::string board, points;
  bool marker = false;
  double marker_radius_m = -1.0;
  std::string from, samples, output, report, json, distance;
  std::vector<std::string> only;
  bool refine = false, force = false, quiet = false;
};

Target target_of(const ExtrinsicsArguments& a) {
  const double radius_m = sphere_radius_m(a.marker_radius_m, a.run);
  return a.marker ? marker_target(radius_m) : wand_target(a.wand_m, radius_m);
}

std::uint32_t camera_named(const std::string& name, const std::vector<SampleCamera>& cameras,
                           const char* option) {
  for (std::uint32_t c = 0; c < cameras.size(); ++c)
    if (cameras[c].name == name) return c;
  std::string names;
  for (const SampleCamera& camera : cameras) names += (names.empty() ? "" : ", ") + camera.name;
  throw UsageError(std::string(option) + ": there is no camera \"" + name + "\"; there are " + names);
}

/// "cam1:cam2:4.95"
KnownCameraDistance distance_of(const std::string& text, const std::vector<SampleCamera>& cameras) {
  const std::size_t first = text.find(':'), second = text.find(':', first + 1);
  char rest = 0;
  KnownCameraDistance known;
  if (first == std::string::npos || second == std::string::npos ||
      std::sscanf(text.c_str() + second + 1, "%lf%c", &known.distance_m, &rest) != 1 ||
      !(known.distance_m > 0.0) || !std::isfinite(known.distance_m))
    throw UsageError("--distance " + text + ": must be CAMERA:CAMERA:METRES, like cam1:cam2:4.95");
  known.a = camera_named(text.substr(0, first), cameras, "--distance");
  known.b = camera_named(text.substr(first + 1, second - first - 1), cameras, "--distance");
  return known;
}

ExtrinsicsOptions options_of(const ExtrinsicsArguments& a, const SampleSet& samples) {
  ExtrinsicsOptions options;
  options.refine_intrinsics = a.refine;
  if (!a.distance.empty()) options.camera_distance = distance_of(a.distance, samples.cameras);
  for (const std::string& name : a.only)
    options.only.push_back(camera_named(name, samples.cameras, "--only"));
  return options;
}

/// The rig's cameras in the samples' order.
std::vector<CameraCalibration> lenses_for(const SampleSet& samples, const std::string& rig_file) {
  if (rig_file.empty()) throw UsageError("--rig FILE is needed with --from: the cameras' intrinsics");
  const Calibration known = read_rig(rig_file).calibration;
  std::vector<CameraCalibration> lenses;
  for (const SampleCamera& wanted : samples.cameras) {
    for (const CameraCalibration& camera : known.cameras)
      if (camera.name == wanted.name) lenses.push_back(camera);
    if (lenses.empty() || lenses.back().name != wanted.name)
      throw Error(rig_file + ": has no camera \"" + wanted.name + "\", which the samples are of");
  }
  return lenses;
}

void print(const CalibrationReport& report) {
  const bool proved = report.quality.sightings_held_out > 0;
  std::printf("camera        fit rms    p95  %s px   left out\n", proved ? "   held out rms    p95 " : "");
  for (const CameraQuality& c : report.quality.cameras) {
    std::printf("%-12s %8.3f %7.3f", c.name.c_str(), c.fit_px.rms, c.fit_px.p95);
    if (proved) std::printf(" %15.3f %7.3f", c.held_out_px.rms, c.held_out_px.p95);
    std::printf(" %14llu\n", static_cast<unsigned long long>(c.outliers));
  }
  for (const LengthQuality& l : report.quality.lengths) {
    std::printf("length %.4f m, %s %llu times: mean error %+.3f mm, sd %.3f mm, p95 %.3f mm, max %.3f mm\n",
                l.true_m, proved ? "held out" : "fitted", static_cast<unsigned long long>(l.error_m.count),
                1e3 * (l.mean_m - l.true_m), 1e3 * l.sd_m, 1e3 * l.error_m.p95, 1e3 * l.error_m.max);
  }
  std::printf("%s: %s\n", word_of(report.judgement.verdict), report.judgement.rule.c_str());
  for (const std::string& reason : report.judgement.reasons()) std::printf("  %s\n", reason.c_str());
}

/// Samples, and the lenses of their cameras in the same order.
struct Input {
  SampleSet samples;
  std::vector<CameraCalibration> lenses;
};

std::filesystem::path samples_file(const ExtrinsicsArguments& a) {
  if (!a.samples.empty()) return a.samples;
  return std::filesystem::path(a.output).replace_extension(".samples.jsonl");
}

Input take_boards(const ExtrinsicsArguments& a, const std::filesystem::path& file) {
  if (a.run.source == "sim")
    throw UsageError("--board with sim: the simulated rig shows each camera a board of its own; use --wand");
  if (a.run.rig_file.empty())
    throw UsageError("--rig FILE is needed: the cameras' intrinsics (glint calibrate intrinsics)");
  BoardSource source;
  source.source = a.run.source;
  source.board = parse_board(a.board);
  source.rig = read_rig(a.run.rig_file);
  source.live = a.run.live;
  source.most_views = 400;
  source.together = true;
  source.quiet = a.quiet;
  BoardSamples taken = collect_board_samples(source);
  if (!a.quiet)
    for (const std::string& note : taken.notes) std::fprintf(stderr, "glint: %s\n", note.c_str());
  if (taken.samples.sightings.empty())
    throw Error(a.run.source + ": the board is never seen by two cameras at the same time");
  write_samples(file, taken.samples, a.force);
  std::vector<CameraCalibration> lenses = lenses_for(taken.samples, a.run.rig_file);
  return {std::move(taken.samples), std::move(lenses)};
}

Input take_input(const ExtrinsicsArguments& a) {
  if (!a.from.empty()) {
    SampleSet samples = read_samples(a.from);
    std::vector<CameraCalibration> lenses = lenses_for(samples, a.run.rig_file);
    return {std::move(samples), std::move(lenses)};
  }
  const std::filesystem::path file = samples_file(a);
  if (!a.board.empty()) return take_boards(a, file);
  WandSamples taken = collect_wand_samples(a.run, target_of(a), a.quiet);
  if (!a.quiet)
    for (const std::string& note : taken.notes) std::fprintf(stderr, "glint: %s\n", note.c_str());
  if (taken.samples.sightings.empty())
    throw Error(a.run.source +
                ": the target was never seen: glint detect shows what the cameras see; nothing was written");
  write_samples(file, taken.samples, a.force);  // kept before anything can go wrong with them
  if (!taken.failure.empty())
    throw Error(taken.failure + "\nthe samples up to then are kept: --from " + file.string() +
                " goes on with them");
  return {std::move(taken.samples), std::move(taken.lenses)};
}

/// What is told twice or never, before anybody waves for a minute in vain.
void check_options(const ExtrinsicsArguments& a) {
  const int targets = (a.marker ? 1 : 0) + (a.wand_m.empty() ? 0 : 1) + (a.board.empty() ? 0 : 1);
  const bool radius = a.marker_radius_m >= 0.0;
  if (!a.points.empty()) {
    if (!a.from.empty() || !a.run.source.empty() || targets > 0 || radius || !a.samples.empty() ||
        !a.distance.empty() || !a.only.empty() || a.refine || !a.report.empty() || !a.json.empty())
      throw UsageError(
          "--points has all that is known of the cameras: only --rig, --output, --force and --quiet go with "
          "it");
    return;
  }
  if (a.from.empty() == a.run.source.empty())
    throw UsageError(
        "give a SOURCE to take samples from, or --from FILE with samples taken before; one of them");
  if (!a.distance.empty() && !a.only.empty())
    throw UsageError("--distance with --only: the cameras that stay give the scale");
  if (!a.from.empty()) {
    if (targets > 0 || radius || !a.samples.empty())
      throw UsageError(
          "--from FILE has its target in it: no --wand, --marker, --board, --radius or --samples with it");
    return;
  }
  if (targets != 1)
    throw UsageError(
        "what is moved? --wand 0,0.13,0.39 (its markers' places in metres), --marker or --board, one of "
        "them");
  if (radius && !a.board.empty()) throw UsageError("--radius with --board: a board has no spheres");
  if (a.marker && a.distance.empty() && a.only.empty())
    throw UsageError(
        "a single marker tells no scale: --distance CAMERA:CAMERA:METRES between two lenses, or a --wand");
  if (!a.marker && !a.distance.empty())
    throw UsageError("--distance is for --marker alone: a wand and a board have their own scale");
}

void check_files(const ExtrinsicsArguments& a) {
  std::vector<std::filesystem::path> files{a.output};
  if (!a.report.empty()) files.emplace_back(a.report);
  if (!a.json.empty()) files.emplace_back(a.json);
  if (!a.run.source.empty()) files.push_back(samples_file(a));
  for (std::size_t i = 0; i < files.size(); ++i) {
    const std::filesystem::path folder = std::filesystem::absolute(files[i]).parent_path();
    if (!std::filesystem::is_directory(folder))
      throw Error(files[i].string() + ": there is no folder " + folder.string());
    if (!a.force && std::filesystem::exists(files[i]))
      throw Error(files[i].string() + ": exists already; --force replaces it");
    for (std::size_t k = 0; k < i; ++k)
      if (files[k].lexically_normal() == files[i].lexically_normal())
        throw UsageError(files[i].string() + ": two things cannot be written to one file");
  }
  const std::string page = std::filesystem::path(a.report).extension().string();
  if (!a.report.empty() && page != ".html" && page != ".htm")
    throw UsageError("--report " + a.report + ": its name must end in .html");
  if (!a.json.empty() && std::filesystem::path(a.json).extension() != ".json")
    throw UsageError("--json " + a.json + ": its name must end in .json");
}

/// Cameras of the rig that the samples are not of stay as they were, too.
void keep_unseen_cameras(const std::string& rig_file, Calibration& solved) {
  if (rig_file.empty()) return;
  Calibration whole = read_rig(rig_file).calibration;
  for (CameraCalibration& camera : whole.cameras)
    for (const CameraCalibration& known : solved.cameras)
      if (known.name == camera.name) camera = known;
  solved.cameras = std::move(whole.cameras);
}

void run(const ExtrinsicsArguments& a) {
  check_options(a);
  check_files(a);
  if (!a.points.empty()) return place_by_known_points({a.points, a.run.rig_file, a.output, a.force});
  const Input input = take_input(a);
  const ExtrinsicsOptions options = options_of(a, input.samples);
  ExtrinsicsResult result = solve_extrinsics(input.samples, input.lenses, options);
  if (a.only.empty()) {
    const Pose up =
        provisional_world_from_world(result.calibration, sample_points(result.calibration, result.samples));
    transform(result.calibration, up);
    transform(result.uncertainty, result.calibration, up);
    result.notes.push_back(
        "the world's z points about upwards and its origin lies below the samples; glint calibrate "
        "ground puts it on the floor");
  }
  result.calibration.made_at = utc_now();
  result.calibration.made_from = "glint calibrate extrinsics, " + result.samples.target.name;
  const CalibrationReport report = make_calibration_report(
      "Calibration of " + std::to_string(input.lenses.size()) + " cameras", result.samples,
      result.calibration, result.quality, result.uncertainty, result.notes, options.only);
  print(report);
  if (!a.quiet)
    for (const std::string& note : result.notes) std::fprintf(stderr, "glint: note: %s\n", note.c_str());
  if (!a.report.empty()) write_calibration_report(a.report, report, a.force);
  if (!a.json.empty()) write_calibration_report(a.json, report, a.force);
  if (report.judgement.verdict == Verdict::Refuse)
    throw Error("refused, no calibration was written: see above for what to do; the samples are kept");
  if (!a.only.empty()) keep_unseen_cameras(a.run.rig_file, result.calibration);
  write_calibration(a.output, result.calibration, a.force);
  std::printf("wrote %s\n", a.output.c_str());
}

}  // namespace

void add_calibrate_extrinsics(CLI::App& calibrate) {
  CLI::App* command = calibrate.add_subcommand("extrinsics", "Find where the cameras stand");
  const auto a = std::make_shared<ExtrinsicsArguments>();
  add_run_options(*command, a->run, "sim, v4l2:[DEVICE,...], images:LOCATION or blobs:FOLDER");
  command->get_option("SOURCE")->required(false);
  command
      ->add_option("--wand", a->wand_m,
                   "places of its two or three markers, metres from the first: 0,0.13,0.39")
      ->delimiter(',');
  command->add_option("--board", a->board,
                      "a printed board instead, seen by two cameras at a time (glint calibrate board)");
  command->add_option(
      "--points", a->points,
      "points measured by other means instead: CSV with camera,x_m,y_m,z_m,x_px,y_px; the world is theirs");
  command->add_flag("--marker", a->marker, "a single marker is moved; needs --distance");
  command->add_option("--radius", a->marker_radius_m, "of the spheres, metres (default: the rig file's)")
      ->check(CLI::Range(0.0, 0.25));
  command->add_option("--distance", a->distance,
                      "CAMERA:CAMERA:METRES, between two lenses: the scale for --marker");
  command->add_option("--from", a->from, "samples taken before, instead of SOURCE");
  command->add_option("--samples", a->samples, "where samples are kept (default: beside the output)");
  command->add_option("-o,--output", a->output, "calibration file to write")->required();
  command->add_option("--report", a->report, "page that shows how good it is, FILE.html");
  command->add_option("--json", a->json, "the same figures for programs, FILE.json");
  command->add_option("--only", a->only, "cameras to place anew, the others stay")->delimiter(',');
  command->add_flag("--refine-intrinsics", a->refine, "let the lenses move within their standard deviations");
  command->add_flag("--force", a->force, "replace existing files");
  command->add_flag("--quiet", a->quiet, "no status line, no messages");
  command->callback([a] { run(*a); });
}

}  // namespace glint::apps
