// SPDX-License-Identifier: MIT
// Command line to SimOptions.
#include "host/apps/sim_arguments.hpp"

#include <numbers>
#include <string>
#include <vector>

#include "host/apps/colon_list.hpp"
#include "host/base/error.hpp"
#include "host/sim/calibration_error.hpp"

namespace glint::apps {
namespace {

SimMotion motion_of(const std::string& name) {
  if (name == "tumbling") return SimMotion::Tumbling;
  if (name == "crossing") return SimMotion::Crossing;
  if (name == "pairs") return SimMotion::Pairs;
  return SimMotion::Thrown;
}

void set_motion(const SimArguments& arguments, SimOptions& options) {
  options.motion = motion_of(arguments.motion);
  if (!arguments.wave_m.empty()) {
    if (!arguments.motion.empty()) throw UsageError("--wave is a motion of its own: leave out --motion");
    options.motion = SimMotion::Wand;
    options.wand_m = arguments.wave_m;
    options.markers = static_cast<std::uint32_t>(options.wand_m.size());
  }
  if (options.person && options.motion != SimMotion::Wand) {
    throw UsageError("--person waves a wand: give --wave as well");
  }
  const bool of_bodies = options.motion == SimMotion::Tumbling || options.motion == SimMotion::Crossing;
  if (options.bodies.count > 0 && !of_bodies) {
    throw UsageError("--bodies are for --motion tumbling and --motion crossing");
  }
  if (!of_bodies) return;
  if (options.bodies.count == 0) options.bodies.count = options.motion == SimMotion::Crossing ? 2 : 3;
  options.markers = options.bodies.count * options.bodies.markers;
}

void set_faults(const SimArguments& arguments, SimFaults& faults) {
  if (!arguments.bump.empty()) {
    const ColonList list("--bump", arguments.bump, "CAMERA:TICK:DEGREES", "2:450:0.5");
    const double angle_rad = list.number<double>(2) * std::numbers::pi / 180.0;
    faults.bump = SimBump{list.camera(0), list.number<std::uint64_t>(1), angle_rad};
  }
  if (!arguments.slip.empty()) {
    const ColonList list("--slip", arguments.slip, "CAMERA:TICK:PULSES", "2:450:3");
    faults.slip = SimSlip{list.camera(0), list.number<std::uint64_t>(1), list.number<int>(2)};
  }
  if (!arguments.swap.empty()) {
    const ColonList list("--swap", arguments.swap, "CAMERA:OTHER:TICK", "2:3:450");
    faults.swap = SimSwap{list.camera(0), list.camera(1), list.number<std::uint64_t>(2)};
  }
  if (!arguments.delay.empty()) {
    const ColonList list("--delay", arguments.delay, "CAMERA:TICK:MS", "2:450:8");
    faults.delay = SimDelay{list.camera(0), list.number<std::uint64_t>(1), list.number<double>(2) * 1e-3};
  }
  for (const std::string& text : arguments.off) {
    const ColonList list("--off", text, "CAMERA:TICK:TICKS", "2:450:90");
    faults.off.push_back({list.camera(0), list.number<std::uint64_t>(1), list.number<std::uint64_t>(2)});
  }
}

}  // namespace

void add_sim_options(CLI::App& command, SimArguments& arguments) {
  SimOptions& o = arguments.options;
  const std::string group = "Simulated rig";
  const auto add = [&](const char* name, auto& value, const char* text) {
    command.add_option(name, value, text)->capture_default_str()->group(group);
  };
  add("--cameras", o.cameras, "number of cameras, 1 to 32");
  add("--markers", o.markers, "number of markers");
  add("--max-speed", o.max_speed_m_s, "fastest marker, m/s");
  add("--seed", o.seed, "same seed, same pictures");
  add("--width", o.width_px, "image width, pixels");
  add("--height", o.height_px, "image height, pixels");
  add("--marker-radius", o.marker_radius_m, "m");
  add("--exposure", o.exposure_s, "s");
  add("--bright-spots", o.bright_spots, "static reflections per camera");
  add("--occluders", o.occluders, "vertical poles in the volume");
  add("--jpeg", o.jpeg_quality, "JPEG quality 1 to 100 that every frame goes through; 0: none");
  add("--drop-rate", o.faults.drop_rate, "share of frames that never arrive");
  add("--duplicate-rate", o.faults.duplicate_rate, "share of frames replaced by the one before");
  add("--missing-rate", o.faults.missing_rate,
      "share of markers that give no light, of each camera and frame its own");
  add("--blinks", o.faults.blinks_per_frame, "pixels that light up in a frame, on average");
  add("--late-rate", o.faults.late_rate, "share of frames that arrive after their set");
  add("--extra-noise", o.faults.extra_noise_grey, "grey levels of noise on top");
  add("--code-seed", o.code_seed, "coded pulses: seed of the dark ones; 0: the light is always on");
  add("--code-group", o.code_group, "pulses for each dark one; 0: as recommended for the rate");
  add("--code-first", o.code_first, "number that the sync board gives to the first pulse");
  command
      .add_option("--motion", arguments.motion,
                  "how markers move: thrown (unless told), tumbling or crossing bodies, touching pairs")
      ->check(CLI::IsMember({"thrown", "tumbling", "crossing", "pairs"}))
      ->group(group);
  command.add_option("--bodies", o.bodies.count, "number of tumbling bodies, 3 unless told")->group(group);
  add("--body-size", o.bodies.size_m, "of tumbling and crossing bodies, m");
  command.add_flag("--identical", o.bodies.identical, "all bodies have the same markers")->group(group);
  add("--calibration-error", arguments.calibration_error_px,
      "pixels by which the calibration given to the tracker is wrong");
  command
      .add_option("--wave", arguments.wave_m,
                  "M,M,..., places on a wand that is waved through the volume, instead of flying markers")
      ->delimiter(',')
      ->group(group);
  command.add_flag("--person", o.person, "the person who waves the wand hides its markers")->group(group);
  command
      .add_option("--off", arguments.off,
                  "CAMERA:TICK:TICKS,..., cameras whose frames do not come from then on, for so many ticks")
      ->delimiter(',')
      ->allow_extra_args(false)
      ->group(group);
  command
      .add_option("--slip", arguments.slip,
                  "CAMERA:TICK:PULSES, a camera that shows earlier exposures from then on")
      ->group(group);
  command
      .add_option("--bump", arguments.bump,
                  "CAMERA:TICK:DEGREES, turn a camera that the calibration does not know of")
      ->group(group);
  command
      .add_option("--swap", arguments.swap, "CAMERA:OTHER:TICK, two cameras that change places from then on")
      ->group(group);
  command
      .add_option("--delay", arguments.delay,
                  "CAMERA:TICK:MS, a camera that exposes so much later from then on")
      ->group(group);
}

SimOptions checked_sim_options(const SimArguments& arguments) {
  SimOptions options = arguments.options;
  std::vector<std::string> problems;
  set_motion(arguments, options);
  set_faults(arguments, options.faults);
  options.check(problems);
  if (!(arguments.calibration_error_px >= 0.0 && arguments.calibration_error_px <= 50.0)) {
    problems.emplace_back("--calibration-error must be 0 to 50 pixels");
  }
  if (problems.empty()) return options;
  std::string text;
  for (const std::string& problem : problems) text += (text.empty() ? "" : "\n") + problem;
  throw UsageError(text);
}

Calibration told_calibration(const SimArguments& arguments, const Calibration& exact) {
  return disturbed(exact, arguments.calibration_error_px, arguments.options.seed);
}

}  // namespace glint::apps
