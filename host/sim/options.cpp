// SPDX-License-Identifier: MIT
// Limits of the simulated rig's options.
#include "host/sim/options.hpp"

#include <algorithm>
#include <cmath>
#include <cstdlib>

#include "gpu/detector.hpp"
#include "host/base/pulse_code.hpp"

namespace glint {
namespace {

class Problems {
 public:
  explicit Problems(std::vector<std::string>& list) : list_(list) {}
  void require(bool fine, const char* text) {
    if (!fine) list_.emplace_back(std::string("sim.") + text);
  }

 private:
  std::vector<std::string>& list_;
};

bool is_rate(double value) { return value >= 0.0 && value <= 1.0; }  // false for NaN

void check_bodies(const SimOptions& o, Problems& p) {
  const SimBodies& bodies = o.bodies;
  if (o.motion == SimMotion::Crossing) {
    p.require(bodies.count == 2, "bodies.count must be 2: two bodies cross");
    p.require(bodies.closest_m >= 2.0 * o.marker_radius_m && bodies.closest_m <= 0.3,
              "bodies.closest_m must be at least a marker's diameter and at most 0.3");
    p.require(bodies.crossing_period_s >= 0.2 && bodies.crossing_period_s <= 100.0,
              "bodies.crossing_period_s must be 0.2 to 100");
  } else {
    p.require(bodies.count >= 1 && bodies.count <= 100, "bodies.count must be 1 to 100");
    p.require(bodies.max_acceleration_m_s2 > 0.0 && bodies.max_acceleration_m_s2 <= 1e5,
              "bodies.max_acceleration_m_s2 must be above 0 and at most 1e5");
  }
  p.require(bodies.markers >= 3 && bodies.markers <= 12, "bodies.markers must be 3 to 12");
  p.require(bodies.size_m >= 0.05 && bodies.size_m <= 1.0, "bodies.size_m must be 0.05 to 1");
  p.require(o.markers == std::uint64_t{bodies.count} * bodies.markers, "markers must be those of all bodies");
}

void check_motion(const SimOptions& o, Problems& p) {
  if (o.motion == SimMotion::Wand) {
    p.require(!o.wand_m.empty() && o.wand_m.front() == 0.0 &&
                  std::is_sorted(o.wand_m.begin(), o.wand_m.end()) && o.wand_m.back() <= 1.5,
              "wand_m must begin with 0 and rise to 1.5 at most");
    p.require(o.markers == o.wand_m.size(), "markers must be those of the wand");
  } else {
    p.require(o.wand_m.empty(), "wand_m is for the motion Wand only");
    p.require(!o.person, "person is for the motion Wand only");
  }
  if (o.motion == SimMotion::Tumbling || o.motion == SimMotion::Crossing) check_bodies(o, p);
  if (o.motion == SimMotion::Pairs) p.require(o.markers % 2 == 0, "markers must be even: they come in pairs");
}

}  // namespace

void SimOptions::check(std::vector<std::string>& problems) const {
  Problems p(problems);
  p.require(cameras >= 1 && cameras <= gpu::kMaxCameras, "cameras must be 1 to 32");
  p.require(markers <= 1000, "markers must be 0 to 1000");
  check_motion(*this, p);
  p.require(rate_hz > 0.0 && rate_hz <= 10000.0, "rate_hz must be above 0 and at most 10000");
  p.require(max_speed_m_s >= 0.0 && max_speed_m_s <= 100.0, "max_speed_m_s must be 0 to 100");
  p.require(width_px >= 32 && width_px <= 8192 && height_px >= 32 && height_px <= 8192 &&
                std::uint64_t{width_px} * height_px <= gpu::kMaxPixels,
            "width_px and height_px must be 32 to 8192, together at most 2^24 pixels");
  p.require(marker_radius_m >= 0.0005 && marker_radius_m <= 0.05, "marker_radius_m must be 0.0005 to 0.05");
  p.require(exposure_s > 0.0 && exposure_s * rate_hz <= 1.0,
            "exposure_s must be above 0 and no longer than a frame period");
  p.require(bright_spots <= 1000, "bright_spots must be 0 to 1000");
  p.require(occluders <= 100, "occluders must be 0 to 100");
  p.require(sensor.full_well_e >= 100.0 && sensor.full_well_e <= 1e6,
            "sensor.full_well_e must be 100 to 1e6");
  p.require(sensor.read_noise_e >= 0.0 && sensor.read_noise_e <= 1e4, "sensor.read_noise_e must be 0 to 1e4");
  p.require(sensor.black_level_grey >= 0.0 && sensor.black_level_grey <= 100.0,
            "sensor.black_level_grey must be 0 to 100");
  p.require(sensor.psf_sigma_px >= 0.3 && sensor.psf_sigma_px <= 5.0, "sensor.psf_sigma_px must be 0.3 to 5");
  p.require(jpeg_quality >= 0 && jpeg_quality <= 100, "jpeg_quality must be 0 (none) to 100");
  p.require(is_rate(faults.drop_rate), "faults.drop_rate must be 0 to 1");
  p.require(is_rate(faults.duplicate_rate), "faults.duplicate_rate must be 0 to 1");
  p.require(is_rate(faults.late_rate), "faults.late_rate must be 0 to 1");
  p.require(faults.late_s >= 0.0 && std::isfinite(faults.late_s), "faults.late_s must be 0 or more");
  p.require(faults.extra_noise_grey >= 0.0 && faults.extra_noise_grey <= 100.0,
            "faults.extra_noise_grey must be 0 to 100");
  p.require(code_group == 0 || (code_group >= PulseCode::kLeastGroup && code_group <= PulseCode::kMostGroup),
            "code_group must be 0 (as recommended for the rate) or 18 to 1024");
  p.require(is_rate(faults.missing_rate), "faults.missing_rate must be 0 to 1");
  p.require(faults.blinks_per_frame >= 0.0 && faults.blinks_per_frame <= 100.0,
            "faults.blinks_per_frame must be 0 to 100");
  p.require(std::all_of(faults.off.begin(), faults.off.end(),
                        [this](const SimOff& off) { return off.camera < cameras; }),
            "faults.off.camera must be one of the rig's cameras");
  if (faults.slip) {
    p.require(faults.slip->camera < cameras, "faults.slip.camera must be one of the rig's cameras");
    p.require(std::abs(faults.slip->pulses) <= 1000, "faults.slip.pulses must be -1000 to 1000");
  }
  if (faults.swap) {
    p.require(faults.swap->camera < cameras && faults.swap->other < cameras &&
                  faults.swap->camera != faults.swap->other,
              "faults.swap must name two of the rig's cameras");
  }
  if (faults.delay) {
    p.require(faults.delay->camera < cameras, "faults.delay.camera must be one of the rig's cameras");
    p.require(std::abs(faults.delay->delay_s) <= 1.0, "faults.delay.delay_s must be -1 to 1");
  }
  if (faults.bump) {
    p.require(faults.bump->camera < cameras, "faults.bump.camera must be one of the rig's cameras");
    p.require(std::abs(faults.bump->angle_rad) <= 0.5, "faults.bump.angle_rad must be -0.5 to 0.5");
  }
}

}  // namespace glint
