// SPDX-License-Identifier: MIT
// The fixed parts of a run's report: what its scenes add to the style sheet of all pages, and the script.
#pragma once

#include <string_view>

namespace glint {

extern const std::string_view kReportStyle;
/// Turns the oblique scene by dragging; the page is complete without it.
extern const std::string_view kReportScript;

}  // namespace glint
