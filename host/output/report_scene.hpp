// SPDX-License-Identifier: MIT
// Cameras and trajectories of a report as SVG text, drawn in parallel projection.
#pragma once

#include <string>

#include "host/output/report.hpp"

namespace glint {

/// Track colour, readable on light and dark ground: "hsl(...)".
std::string track_colour(std::size_t position);

/// Seen from above the horizon; every element carries its world coordinates in data-p, so that the
/// page's script can turn the view.
std::string oblique_scene_svg(const ReportData& data);

/// Seen from above: x to the right, y up.
std::string top_scene_svg(const ReportData& data);

}  // namespace glint
