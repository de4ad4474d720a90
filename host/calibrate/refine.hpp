// SPDX-License-Identifier: MIT
// A calibration made better by what was tracked since, if it really gets better.
#pragma once

#include <string>
#include <vector>

#include "host/calibrate/quality.hpp"
#include "host/calibrate/samples.hpp"
#include "host/geometry/camera.hpp"

namespace glint {

/// Points of tracked markers for a refinement: every tick's points are markers of their own, since nothing is
/// known of how they belong together.
class TrackedSamples {
 public:
  TrackedSamples(std::vector<SampleCamera> cameras, double marker_radius_m);

  /// One marker at one exposure, in the order of time; of `sightings` cameras and pixels are used. Fewer than
  /// three views are ignored: they fit any calibration too easily.
  void add(std::span<const Sighting> sightings);
  /// Thinned evenly to at most this many markers.
  SampleSet take(std::size_t most);

 private:
  SampleSet samples_;
  std::vector<std::size_t> begins_;  // of each marker
};

struct Refinement {
  Calibration calibration;
  CalibrationQuality before,
      after;            ///< of the same held-out markers, of which both calibrations knew nothing
  bool better = false;  ///< the held-out median error fell by 2 % at least and no camera's rose by 5 %
  std::string reason;   ///< why, in figures
  double worst_shift_m = 0.0,
         worst_turn_rad = 0.0;  ///< of a camera, after the best alignment with what was before
};

/// Bundle adjustment of all camera poses from where they are. Size, place and turn of the rig stay as they
/// were (the best alignment of the cameras), because markers of unknown distance tell nothing of
/// them. Intrinsics are not touched. Throws Error if there are too few markers or a camera saw too few of
/// them.
Refinement refine(const Calibration& calibration, const SampleSet& samples);

}  // namespace glint
