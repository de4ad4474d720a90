// SPDX-License-Identifier: MIT
// The [capture] section of a rig file; private to host/config.
#pragma once

#include "host/config/rig.hpp"
#include "host/config/toml_section.hpp"

namespace glint {

/// Reads its keys and tables. Cameras must be those of `calibration`, unless that could not be read.
void read_capture(TomlSection& section, const Calibration& calibration, CaptureSettings& capture,
                  FileProblems& problems);

}  // namespace glint
