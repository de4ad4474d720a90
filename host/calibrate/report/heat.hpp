// SPDX-License-Identifier: MIT
// Colours for values from good to bad, readable on light and dark ground and without red-green vision.
#pragma once

#include <string>

namespace glint {

/// 0: best (blue), 1: worst (red-orange); beyond is cut off. "#rrggbb", in 48 steps.
std::string heat_colour(double share);

/// A round number that is not smaller: where a scale may end.
double round_top(double value);

/// A bar with the colours, 10 units high, with labels from 0 to `top` below it and the unit behind it. SVG
/// elements.
std::string heat_scale_svg(double x, double y, double width, double top, const std::string& unit);

}  // namespace glint
