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
};

/// Reads the source to its end, or until Ctrl-C, and tells meanwhile what is missing (unless quiet).
/// `arguments.source` may also be sim, which then waves the target. `opened` is told the rig
/// before the first exposure, `on_tick` sees each. Throws Error, UsageError.
WandSamples collect_wand_samples(RunArguments arguments, const Target& target, bool quiet,
                                 const std::function<void(const Rig&)>& opened = {},
                                 const std::function<void(const TickBlobs&)>& on_tick = {});

}  // namespace glint::apps
