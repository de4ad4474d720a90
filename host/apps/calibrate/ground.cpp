// SPDX-License-Identifier: MIT
// `glint calibrate ground`: puts the world's origin and axes on the floor, and its size right.
#include <cmath>
#include <cstdio>
#include <memory>
#include <numbers>
#include <sstream>

#include "host/apps/calibrate/board_samples.hpp"
#include "host/apps/calibrate/commands.hpp"
#include "host/apps/calibrate/still_markers.hpp"
#include "host/apps/utc_time.hpp"
#include "host/base/error.hpp"
#include "host/calibrate/ground.hpp"
#include "host/calibrate/still_board.hpp"
#include "host/config/rig.hpp"

namespace glint::apps {
namespace {

struct GroundArguments {
  RunArguments run;
  std::string l_frame, board, output, scale;
  std::vector<double> origin_m, on_x_m, in_plane_m, shift_m;
  double height_m = 0.0, rotate_deg = 0.0;
  bool force = false, quiet = false;
};

std::vector<double> numbers_of(const std::string& text, const std::string& option) {
  std::vector<double> numbers;
  std::istringstream list(text);
  for (std::string item; std::getline(list, item, ',');) {
    char rest = 0;
    double value = 0.0;
    if (std::sscanf(item.c_str(), "%lf%c", &value, &rest) != 1)
      throw UsageError(option + ": \"" + item + "\" is no number");
    numbers.push_back(value);
  }
  return numbers;
}

/// "0.2,0.5:0.3"
LFrame l_frame_of(const std::string& text, double height_m) {
  const std::size_t colon = text.find(':');
  if (colon == std::string::npos) {
    throw UsageError("--l-frame " + text +
                     ": must be the distances from the corner's marker along x, then along y, in metres, "
                     "like 0.2,0.5:0.3");
  }
  return {numbers_of(text.substr(0, colon), "--l-frame"), numbers_of(text.substr(colon + 1), "--l-frame"),
          height_m};
}

Eigen::Vector3d vector_of(const std::vector<double>& numbers) { return {numbers[0], numbers[1], numbers[2]}; }

/// Measured and true metres.
double scale_of(const std::string& text) {
  double measured = 0.0, true_m = 0.0;
  char rest = 0;
  if (std::sscanf(text.c_str(), "%lf:%lf%c", &measured, &true_m, &rest) != 2 || !(measured > 0.0) ||
      !(true_m > 0.0) || !std::isfinite(measured / true_m) || !std::isfinite(true_m / measured))
    throw UsageError("--scale " + text + ": must be MEASURED:TRUE in metres, like 1.004:1");
  return scale_for_distance(Eigen::Vector3d::Zero(), Eigen::Vector3d(measured, 0.0, 0.0), true_m);
}

void check(const GroundArguments& a) {
  const bool places = !a.origin_m.empty() || !a.on_x_m.empty() || !a.in_plane_m.empty();
  if (places && (a.origin_m.empty() || a.on_x_m.empty() || a.in_plane_m.empty()))
    throw UsageError("--origin, --on-x and --in-plane belong together");
  if (places + !a.l_frame.empty() + !a.board.empty() > 1)
    throw UsageError("--l-frame, or --board, or --origin, --on-x and --in-plane: one of them");
  if ((a.l_frame.empty() && a.board.empty()) != a.run.source.empty())
    throw UsageError(
        "--l-frame and --board need a SOURCE that sees it lie still, and nothing else needs one");
  if (!a.board.empty() && a.run.source == "sim")
    throw UsageError("--board with sim: the simulated rig shows each camera a board of its own");
  if (!places && a.l_frame.empty() && a.board.empty() && a.shift_m.empty() && a.rotate_deg == 0.0 &&
      a.scale.empty())
    throw UsageError(
        "nothing to do: --l-frame, or --board, or --origin, --on-x and --in-plane, or --rotate, --shift, "
        "--scale");
  if (a.run.rig_file.empty()) throw UsageError("--rig FILE is needed: the calibration to change");
}

StillBoard board_on_floor(const GroundArguments& a, const Calibration& calibration) {
  constexpr std::size_t kViews = 10;  // noise averages out, and what moves shows
  BoardSource source;
  source.source = a.run.source;
  source.board = parse_board(a.board);
  if (!source.board.orientation_known()) {
    throw UsageError(
        "--board " + a.board +
        ": looks the same after half a turn, so that its origin may be at either end; take one with "
        "an odd and an even number of squares, or a charuco");
  }
  source.rig = read_rig(a.run.rig_file);
  source.live = a.run.live;
  source.most_views = kViews;
  source.still = true;
  source.quiet = a.quiet;
  const BoardSamples taken = collect_board_samples(source);
  if (!a.quiet || taken.samples.sightings.empty())
    for (const std::string& note : taken.notes) std::fprintf(stderr, "glint: %s\n", note.c_str());
  return place_still_board(taken.samples, calibration);
}

void run(const GroundArguments& a) {
  check(a);
  Calibration calibration = read_rig(a.run.rig_file).calibration;
  std::vector<std::string> notes;
  const auto place = [&](const Ground& ground) {
    transform(calibration, ground.new_world_from_world);
    notes.insert(notes.end(), ground.notes.begin(), ground.notes.end());
    if (ground.fit_rms_m > 0.0)
      std::printf("the frame's markers fit to %.2f mm rms\n", 1e3 * ground.fit_rms_m);
  };
  if (!a.l_frame.empty()) {
    RunArguments arguments = a.run;
    if (!arguments.seconds && arguments.max_ticks == 0) arguments.seconds = 2.0;
    const LFrame frame = l_frame_of(a.l_frame, a.height_m);
    place(ground_from_l_frame(still_markers(arguments, a.quiet), frame, calibration));
  } else if (!a.board.empty()) {
    const StillBoard board = board_on_floor(a, calibration);
    std::printf("the board, seen by %zu camera%s, fits to %.2f px rms\n", board.cameras,
                board.cameras == 1 ? "" : "s", board.rms_px);
    place(ground_from_board(board.world_from_board, a.height_m, calibration));
  } else if (!a.origin_m.empty()) {
    place(ground_from_markers(vector_of(a.origin_m), vector_of(a.on_x_m), vector_of(a.in_plane_m), a.height_m,
                              calibration));
  }
  // Afterwards, in the world that is then: turned about z, moved, enlarged.
  Pose after;
  after.rotation = Eigen::AngleAxisd(a.rotate_deg * std::numbers::pi / 180.0, Eigen::Vector3d::UnitZ());
  if (!a.shift_m.empty()) after.translation = vector_of(a.shift_m);
  transform(calibration, after, a.scale.empty() ? 1.0 : scale_of(a.scale));
  calibration.made_at = utc_now();
  calibration.made_from += ", ground";
  write_calibration(a.output, calibration, a.force);
  for (const std::string& note : notes) std::fprintf(stderr, "glint: note: %s\n", note.c_str());
  for (const CameraCalibration& camera : calibration.cameras) {
    const Eigen::Vector3d& p = camera.world_from_camera.translation;
    std::printf("%-10s stands at (%.3f, %.3f, %.3f) m\n", camera.name.c_str(), p.x(), p.y(), p.z());
  }
  std::printf("wrote %s\n", a.output.c_str());
}

}  // namespace

void add_calibrate_ground(CLI::App& calibrate) {
  CLI::App* command =
      calibrate.add_subcommand("ground", "Put origin and axes on the floor; turn, shift, rescale");
  const auto a = std::make_shared<GroundArguments>();
  add_run_options(*command, a->run,
                  "for --l-frame: sim, v4l2:[DEVICE,...], images:LOCATION or blobs:FOLDER; for --board: "
                  "v4l2:[DEVICE,...] or images:LOCATION");
  command->get_option("SOURCE")->required(false);
  command->add_option(
      "--l-frame", a->l_frame,
      "markers on a right angle, metres from its corner's: along x : along y, like 0.2,0.5:0.3");
  command->add_option("--board", a->board,
                      "printed board that lies on the floor, like charuco:8x5:60mm:44mm:5X5_100");
  command
      ->add_option("--above-floor", a->height_m,
                   "of the markers' centres, or of the board's printed side, above the floor, metres")
      ->capture_default_str();
  const auto place = [&](const char* name, std::vector<double>& value, const char* text) {
    command->add_option(name, value, text)->delimiter(',')->expected(3);
  };
  place("--origin", a->origin_m, "X,Y,Z of a marker that shall be the origin, as glint track shows it now");
  place("--on-x", a->on_x_m, "X,Y,Z of a marker on the x axis");
  place("--in-plane", a->in_plane_m, "X,Y,Z of a third one on the floor, on the side of positive y");
  command->add_option("--rotate", a->rotate_deg, "about z, degrees, counter-clockwise from above");
  place("--shift", a->shift_m, "X,Y,Z in metres, added to all places");
  command->add_option("--scale", a->scale, "MEASURED:TRUE, metres of one distance");
  command->add_option("-o,--output", a->output, "calibration file to write")->required();
  command->add_flag("--force", a->force, "replace an existing file");
  command->add_flag("--quiet", a->quiet, "no messages");
  command->callback([a] { run(*a); });
}

}  // namespace glint::apps
