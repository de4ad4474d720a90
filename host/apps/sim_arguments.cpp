// SPDX-License-Identifier: MIT
// Command line to SimOptions.
#include "host/apps/sim_arguments.hpp"

#include <cstdio>
#include <numbers>
#include <string>
#include <vector>

#include "host/base/error.hpp"

namespace glint::apps {

void add_sim_options(CLI::App& command, SimArguments& arguments) {
  SimOptions& o = arguments.options;
  const std::string group = "Simulated rig";
  const auto add = [&](const char* name, auto& value, const char* text) {
    command.add_option(name, value, text)->capture_default_str()->group(group);
  };
  add("--cameras", o.cameras, "number of cameras, 1 to 32");
  add("--markers", o.markers, "number of flying markers");
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
  add("--late-rate", o.faults.late_rate, "share of frames that arrive after their set");
  add("--extra-noise", o.faults.extra_noise_grey, "grey levels of noise on top");
  add("--code-seed", o.code_seed, "coded pulses: seed of the dark ones; 0: the light is always on");
  add("--code-group", o.code_group, "pulses for each dark one; 0: as recommended for the rate");
  add("--code-first", o.code_first, "number that the sync board gives to the first pulse");
  command
      .add_option("--wave", arguments.wave_m,
                  "M,M,..., places on a wand that is waved through the volume, instead of flying markers")
      ->delimiter(',')
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
  if (!arguments.wave_m.empty()) {
    options.wand_m = arguments.wave_m;
    options.markers = static_cast<std::uint32_t>(options.wand_m.size());
  }
  if (!arguments.bump.empty()) {
    unsigned camera = 0;
    unsigned long long tick = 0;
    double degrees = 0.0;
    char rest = 0;
    if (std::sscanf(arguments.bump.c_str(), "%u:%llu:%lf%c", &camera, &tick, &degrees, &rest) != 3 ||
        camera == 0) {
      throw UsageError("--bump " + arguments.bump + ": must be CAMERA:TICK:DEGREES, like 2:450:0.5");
    }
    options.faults.bump = SimBump{camera - 1, tick, degrees * std::numbers::pi / 180.0};
  }
  if (!arguments.slip.empty()) {
    unsigned camera = 0;
    unsigned long long tick = 0;
    int pulses = 0;
    char rest = 0;
    if (std::sscanf(arguments.slip.c_str(), "%u:%llu:%d%c", &camera, &tick, &pulses, &rest) != 3 ||
        camera == 0) {
      throw UsageError("--slip " + arguments.slip + ": must be CAMERA:TICK:PULSES, like 2:450:3");
    }
    options.faults.slip = SimSlip{camera - 1, tick, pulses};
  }
  if (!arguments.swap.empty()) {
    unsigned camera = 0, other = 0;
    unsigned long long tick = 0;
    char rest = 0;
    if (std::sscanf(arguments.swap.c_str(), "%u:%u:%llu%c", &camera, &other, &tick, &rest) != 3 ||
        camera == 0 || other == 0) {
      throw UsageError("--swap " + arguments.swap + ": must be CAMERA:OTHER:TICK, like 2:3:450");
    }
    options.faults.swap = SimSwap{camera - 1, other - 1, tick};
  }
  if (!arguments.delay.empty()) {
    unsigned camera = 0;
    unsigned long long tick = 0;
    double milliseconds = 0.0;
    char rest = 0;
    if (std::sscanf(arguments.delay.c_str(), "%u:%llu:%lf%c", &camera, &tick, &milliseconds, &rest) != 3 ||
        camera == 0) {
      throw UsageError("--delay " + arguments.delay + ": must be CAMERA:TICK:MS, like 2:450:8");
    }
    options.faults.delay = SimDelay{camera - 1, tick, milliseconds * 1e-3};
  }
  options.check(problems);
  if (problems.empty()) return options;
  std::string text;
  for (const std::string& problem : problems) text += (text.empty() ? "" : "\n") + problem;
  throw UsageError(text);
}

}  // namespace glint::apps
