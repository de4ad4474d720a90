// SPDX-License-Identifier: MIT
// `glint calibrate intrinsics`: the lens of each camera, from pictures of a board.
#include <cstdio>
#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "host/apps/calibrate/board_samples.hpp"
#include "host/apps/calibrate/commands.hpp"
#include "host/apps/calibrate/intrinsics_report.hpp"
#include "host/apps/utc_time.hpp"
#include "host/base/error.hpp"
#include "host/calibrate/intrinsics.hpp"
#include "host/config/rig.hpp"
#include "host/files/text_file.hpp"

namespace glint::apps {
namespace {

struct IntrinsicsArguments {
  BoardSource source;
  std::string board, from, samples, output, json, model = "radial-tangential";
  std::vector<std::string> only;
  bool k3 = false, least_squares = false, force = false;
};

void check(const IntrinsicsArguments& a) {
  if (a.model == "rational") {
    throw UsageError(
        "--model rational: glint's lens model is the radial-tangential one (k1 k2 p1 p2 k3), also while "
        "tracking; the "
        "rational model of 8 coefficients is not supported. For wide lenses use --k3; fisheye lenses beyond "
        "about 120 "
        "degrees cannot be used");
  }
  if (a.model != "radial-tangential") throw UsageError("--model " + a.model + ": must be radial-tangential");
  if (a.from.empty() == a.source.source.empty())
    throw UsageError("give a SOURCE of pictures, or --from FILE with samples taken before; one of them");
  if (a.from.empty() && a.board.empty())
    throw UsageError("--board is needed, like chessboard:9x6:25mm; glint calibrate board prints one");
  for (const std::string& file : {a.output, a.json}) {
    if (!file.empty() && !a.force && std::filesystem::exists(file))
      throw Error(file + ": exists already; --force replaces it, with all cameras in it");
  }
}

bool wanted(const IntrinsicsArguments& a, const std::string& camera) {
  return a.only.empty() || std::find(a.only.begin(), a.only.end(), camera) != a.only.end();
}

SampleSet take_samples(const IntrinsicsArguments& a, Calibration& truth) {
  if (!a.from.empty()) return read_samples(a.from);
  const std::filesystem::path file =
      !a.samples.empty() ? std::filesystem::path(a.samples)
                         : std::filesystem::path(a.output).replace_extension(".samples.jsonl");
  if (!a.force && std::filesystem::exists(file))
    throw Error(file.string() + ": exists already; --force replaces it");
  BoardSource source = a.source;
  source.board = parse_board(a.board);
  BoardSamples taken = collect_board_samples(source);
  truth = std::move(taken.truth);
  for (const std::string& note : taken.notes) {
    if (!source.quiet) std::fprintf(stderr, "glint: %s\n", note.c_str());
  }
  std::string without;
  for (std::uint32_t c = 0; c < taken.samples.cameras.size(); ++c) {
    bool any = !wanted(a, taken.samples.cameras[c].name);
    for (const Sighting& s : taken.samples.sightings) any = any || s.camera == c;
    if (!any) without += (without.empty() ? "" : "\n") + taken.notes[c];
  }
  // Kept before anything can go wrong with them.
  if (!taken.samples.sightings.empty()) write_samples(file, taken.samples, a.force);
  if (!without.empty()) throw Error(without);
  return taken.samples;
}

void run(const IntrinsicsArguments& a) {
  check(a);
  Calibration truth;
  const SampleSet samples = take_samples(a, truth);
  for (const std::string& name : a.only) {
    const bool known = std::any_of(samples.cameras.begin(), samples.cameras.end(),
                                   [&](const SampleCamera& camera) { return camera.name == name; });
    if (!known) throw UsageError("--only " + name + ": there is no such camera");
  }
  IntrinsicsOptions options;
  options.k3 = a.k3;
  options.robust = !a.least_squares;
  std::vector<IntrinsicsResult> results;
  std::string problems;
  for (std::uint32_t c = 0; c < samples.cameras.size(); ++c) {
    if (!wanted(a, samples.cameras[c].name)) continue;
    try {
      results.push_back(calibrate_intrinsics(samples, c, options));
    } catch (const Error& error) {
      problems += (problems.empty() ? "" : "\n") + std::string(error.what());
    }
  }
  Calibration calibration;
  calibration.made_at = utc_now();
  calibration.made_from = "glint calibrate intrinsics, " + samples.target.name;
  for (const IntrinsicsResult& result : results) {
    std::fputs(intrinsics_text(result).c_str(), stdout);
    for (const CameraCalibration& camera : truth.cameras)
      if (camera.name == result.camera.name) std::fputs(truth_text(result, camera).c_str(), stdout);
    calibration.cameras.push_back(result.camera);
    if (result.verdict == Verdict::Refuse)
      problems += (problems.empty() ? "" : "\n") + result.camera.name + ": " + result.rule;
  }
  std::fflush(stdout);
  if (!a.json.empty())
    write_text_file(a.json, intrinsics_json(samples.target.name, results).dump(2) + "\n", a.force);
  if (!problems.empty()) throw Error(problems + "\nno calibration was written");
  write_calibration(a.output, calibration, a.force);
  std::printf("wrote %s; where the cameras stand is not known yet: glint calibrate extrinsics\n",
              a.output.c_str());
}

}  // namespace

void add_calibrate_intrinsics(CLI::App& calibrate) {
  CLI::App* command =
      calibrate.add_subcommand("intrinsics", "Find focal length, centre and distortion of each camera");
  const auto a = std::make_shared<IntrinsicsArguments>();
  command->add_option("SOURCE", a->source.source,
                      "images:LOCATION, a folder of pictures or a video; v4l2:[NAME=]DEVICE,...; sim");
  command->add_option(
      "--board", a->board,
      "chessboard:9x6:25mm (inner corners, square) or charuco:8x5:30mm:22mm:5X5_100 (squares, square, "
      "marker, dictionary)");
  command->add_option("-o,--output", a->output, "calibration file to write")->required();
  command->add_option("--samples", a->samples, "where the corners are kept (default: beside the output)");
  command->add_option("--from", a->from, "corners found before, instead of SOURCE");
  command->add_option("--only", a->only, "cameras to calibrate; the others are left out")->delimiter(',');
  command->add_option("--json", a->json, "all figures, for programs");
  command->add_flag("--k3", a->k3, "estimate k3, too: for wide lenses");
  command->add_option("--model", a->model, "radial-tangential")->capture_default_str();
  command->add_option("--views", a->source.most_views, "most views kept of each camera")
      ->check(CLI::Range(5, 1000))
      ->capture_default_str();
  command
      ->add_option("--corner-reach", a->source.finder.reach_px,
                   "pixels around a corner that are looked at; 0: as many as are free of other corners")
      ->check(CLI::Range(0, 50))
      ->capture_default_str();
  command->add_flag("--least-squares", a->least_squares,
                    "no robust loss, no view left out: for comparison with OpenCV's calibrateCamera");
  command->add_flag("--force", a->force, "replace existing files");
  command->add_flag("--quiet", a->source.quiet, "no progress, no notes");
  command->add_option("--camera-format", a->source.live.format, "v4l2: auto, grey, nv12, yuyv or mjpeg");
  command->add_option("--camera-size", a->source.live.size, "v4l2: WIDTHxHEIGHT");
  command->add_option("--sim-views", a->source.sim_views, "sim: pictures of each camera")
      ->check(CLI::Range(1, 10000))
      ->capture_default_str();
  add_sim_options(*command, a->source.sim);
  command->callback([a] { run(*a); });
}

}  // namespace glint::apps
