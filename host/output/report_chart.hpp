// SPDX-License-Identifier: MIT
// Plots of a report as SVG text. Colours come from the page's style sheet.
#pragma once

#include <string>
#include <vector>

#include "host/output/latency_histogram.hpp"

namespace glint {

/// 0.00123 -> "1.23 ms".
std::string duration_text(double seconds);

/// Share of ticks by latency on a logarithmic axis, with p50, p99 and the maximum marked.
std::string latency_chart_svg(const LatencyHistogram& latency);

/// A step line over time from zero up; `nominal` is drawn dashed where it is > 0.
struct StepChart {
  std::string unit;             ///< of the vertical axis
  std::vector<double> start_s;  ///< where each step begins
  std::vector<double> value;
  double nominal = 0.0;
};
std::string step_chart_svg(const StepChart& chart);

}  // namespace glint
