// SPDX-License-Identifier: MIT
// The fixed parts of a report page: style sheet and script.
#pragma once

#include <string_view>

namespace glint {

extern const std::string_view kReportStyle;
/// Turns the oblique scene by dragging; the page is complete without it.
extern const std::string_view kReportScript;

}  // namespace glint
