// SPDX-License-Identifier: MIT
// What a calibration's report adds to the style of all pages.
#pragma once

#include <string_view>

namespace glint {

extern const std::string_view kCalibrationStyle;

}  // namespace glint
