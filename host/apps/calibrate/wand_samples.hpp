// SPDX-License-Identifier: MIT
// From a running rig to calibration samples of a marker or a wand.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "host/apps/run_arguments.hpp"
#include "host/calibrate/samples.hpp"

namespace glint::apps {

struct WandSamples {
  SampleSet samples;
  std::vector<CameraCalibration> lenses;  ///< of the rig that was used, in the samples' order
  std::vector<std::string> notes;         ///< what was not found, camera by camera
  std::string failure;                    ///< what went wrong in the middle of it; empty: nothing
};

/// Reads the source to its end, or until Ctrl-C, and tells meanwhile what is missing (unless quiet).
/// `arguments.source` may also be sim, which then waves the target. `opened` is told the rig
/// before the first exposure, `on_tick` sees each. Throws Error, UsageError; but a source that fails after
/// samples were taken ends them, and is told in `failure`.
WandSamples collect_wand_samples(RunArguments arguments, const Target& target, bool quiet,
                                 const std::function<void(const Rig&)>& opened = {},
                                 const std::function<void(const TickBlobs&)>& on_tick = {});

/// Of the target's spheres: `given` if it is not negative, else the simulated rig's, else what the rig file
/// says.
double sphere_radius_m(double given, const RunArguments& arguments);

}  // namespace glint::apps
