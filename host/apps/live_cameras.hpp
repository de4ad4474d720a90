// SPDX-License-Identifier: MIT
// From `v4l2:...` and the rig file's [capture] to the cameras that are to be opened.
#pragma once

#include <string>
#include <string_view>

#include "host/capture/v4l2/v4l2_source.hpp"
#include "host/config/rig.hpp"

namespace glint::apps {

struct LiveArguments {
  std::string format, size;  ///< over the rig file's; size "1280x800" only where there is no calibration
};

/// `pulse_rate_hz`: frame sets per second; 0: as fast as the cameras are set to. `devices`: "" for the
/// cameras of rig.capture, else [NAME=]DEVICE,... for all cameras of the calibration, by name or in their
/// order; without a calibration cam1, cam2, ... if they bring no names. What happens to cameras is printed on
/// standard error. Throws UsageError.
V4l2Options live_options(std::string_view devices, double pulse_rate_hz, const Rig& rig,
                         const LiveArguments& arguments);

/// One line on standard error about something that has happened while a run goes on. Any thread.
void print_event(const std::string& text);

}  // namespace glint::apps
