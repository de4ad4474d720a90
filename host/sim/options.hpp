// SPDX-License-Identifier: MIT
// Everything that can be asked of the simulated rig, with defaults and their reasons.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

namespace glint {

/// Global-shutter sensor and lens blur. docs/simulated-rig.md says where each figure comes from.
struct SimSensor {
  double full_well_e = 6300.0;    ///< electrons between black and 255
  double read_noise_e = 5.0;      ///< sd per pixel
  double black_level_grey = 8.0;  ///< mean of a dark frame
  double psf_sigma_px = 0.6;      ///< optical blur, Gaussian, before the pixel integrates over its square
};

/// A camera that is knocked: from `tick` on it is turned about its own y axis (down) by `angle_rad`; the
/// calibration does not know.
struct SimBump {
  std::uint32_t camera = 0;
  std::uint64_t tick = 0;
  double angle_rad = 0.0;
};

/// A camera that begins to queue frames: from `tick` on its frames show the exposure `pulses` earlier (later
/// if negative), its stamps and sequence numbers as before but for one irregular step.
struct SimSlip {
  std::uint32_t camera = 0;
  std::uint64_t tick = 0;
  int pulses = 0;
};

/// Two cameras that change places, as if cables or devices were exchanged: from `tick` on the frames of one
/// come as those of the other.
struct SimSwap {
  std::uint32_t camera = 0, other = 1;
  std::uint64_t tick = 0;
};

/// A camera that is triggered too late: from `tick` on it exposes `delay_s` after the others (before them if
/// negative), under the time stamps of a camera that is on time.
struct SimDelay {
  std::uint32_t camera = 0;
  std::uint64_t tick = 0;
  double delay_s = 0.0;
};

/// A camera whose frames never come: `ticks` of them from `tick` on.
struct SimOff {
  std::uint32_t camera = 0;
  std::uint64_t tick = 0, ticks = 0;
};

/// Faults on request. Rates are per frame and camera where nothing else is said.
struct SimFaults {
  double drop_rate = 0.0;         ///< the frame is exposed but never arrives; its sequence number is missing
  double duplicate_rate = 0.0;    ///< the previous image comes again under its old sequence number
  double late_rate = 0.0;         ///< the frame arrives `late_s` after its set
  double late_s = 0.02;           ///< later than half a period: missing in its set
  double extra_noise_grey = 0.0;  ///< sd of noise added to every pixel
  std::optional<SimBump> bump;
  std::optional<SimSlip> slip;
  std::optional<SimSwap> swap;
  std::optional<SimDelay> delay;
  std::vector<SimOff> off;
  double missing_rate = 0.0;      ///< per marker: it gives no light, in one camera and one exposure
  double blinks_per_frame = 0.0;  ///< expected number of pixels or 2x2 clusters that light up for one frame
};

/// How markers move.
enum class SimMotion : std::uint8_t {
  Thrown,    ///< balls in gravity that bounce for ever
  Wand,      ///< a person waves a wand with markers at `wand_m`
  Tumbling,  ///< rigid bodies, each swinging and turning in a part of the volume of its own
  Crossing,  ///< two rigid bodies that meet again and again, closely
  Pairs      ///< pairs of balls that touch, part, and slide round each other
};

/// Rigid bodies of Tumbling and Crossing.
struct SimBodies {
  std::uint32_t count = 0;
  std::uint32_t markers = 5;             ///< of each
  double size_m = 0.2;                   ///< diameter of the ball that holds a body's markers
  bool identical = false;                ///< all have the same markers
  double max_acceleration_m_s2 = 110.0;  ///< Tumbling: of any marker
  double closest_m = 0.05;               ///< Crossing: smallest distance between markers of the two
  double crossing_period_s = 1.0;        ///< Crossing: they meet once in each
};

struct SimOptions {
  std::uint32_t cameras = 4;   ///< 1..32; up to four stand on the corners, more on the circle through them
  std::uint32_t markers = 20;  ///< in all: of all bodies, of the wand, two of each pair
  double rate_hz = 90.0;
  double max_speed_m_s = 10.0;  ///< Thrown, Tumbling: no marker is ever faster; 0: they hang still
  std::uint32_t width_px = 1280, height_px = 800;  ///< OV9281; the field of view across stays the same
  double marker_radius_m = 0.0063;
  SimMotion motion = SimMotion::Thrown;
  std::vector<double> wand_m;  ///< Wand: places of the markers on its axis, the first at 0
  bool person = false;         ///< Wand: the person who waves it stands in the way of light
  SimBodies bodies;            ///< Tumbling, Crossing
  double exposure_s = 137e-6;  ///< brightness is in proportion
  std::uint64_t seed = 1;
  std::uint32_t bright_spots = 5;  ///< static reflections per camera, as in a real room
  std::uint32_t occluders = 0;     ///< dark vertical poles in the volume
  SimSensor sensor;
  /// Coded pulses (host/base/pulse_code.hpp): markers are black in dark ones. 0: the light is always on.
  std::uint32_t code_seed = 0;
  std::uint32_t code_group = 0;  ///< pulses for each dark one; 0: as recommended for the rate
  std::uint32_t code_first = 0;  ///< number that the board gives to the pulse of tick 0
  int jpeg_quality = 0;          ///< 1..100: every frame goes through JPEG; 0: not
  SimFaults faults;

  void check(std::vector<std::string>& problems) const;  ///< appends "sim.markers must be ..."
};

}  // namespace glint
