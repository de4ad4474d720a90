// SPDX-License-Identifier: MIT
// Axes, histogram and step line.
#include "host/output/report_chart.hpp"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>

#include "host/page/page_text.hpp"
#include "host/page/svg.hpp"

namespace glint {

namespace {

using svg::coordinate, svg::label, svg::line;

constexpr double kWidth = 520, kHeight = 230;  // user units of the viewBox
constexpr double kLeft = 52, kRight = 14, kTop = 30, kBottom = 40;
constexpr double kPlotRight = kWidth - kRight, kPlotBottom = kHeight - kBottom;

std::string nothing_measured(const std::string& what) {
  return svg::begin(kWidth, kHeight, what) +
         label("mid", kWidth / 2, kHeight / 2, "not measured in this run") + "</svg>";
}

std::string vertical_axis(double top, const std::string& unit) {
  std::string s;
  const double step = round_step(top, 4);
  for (double v = 0; v <= top * 1.0001; v += step) {
    const double y = kPlotBottom - v / top * (kPlotBottom - kTop);
    s += line(v == 0 ? "axis" : "grid", kLeft, y, kPlotRight, y);
    s += label("end", kLeft - 8, y + 4, short_number(v));
  }
  return s + label("start unit", 4, 14, unit);
}

}  // namespace

std::string duration_text(double seconds) {
  if (!std::isfinite(seconds)) return "?";
  const bool in_seconds = seconds >= 1.0, in_us = seconds < 1e-3;
  const double value = in_seconds ? seconds : in_us ? seconds * 1e6 : seconds * 1e3;
  const int decimals = value < 10 ? 2 : value < 100 ? 1 : 0;
  std::array<char, 400> digits{};
  const auto end =
      std::to_chars(digits.data(), digits.data() + digits.size(), value, std::chars_format::fixed, decimals);
  return std::string(digits.data(), end.ptr) + (in_seconds ? " s" : in_us ? " \u00b5s" : " ms");
}

std::string latency_chart_svg(const LatencyHistogram& latency) {
  if (latency.count() == 0) return nothing_measured("latency histogram");
  // From a 1-2-5 step below the smallest to one above the largest value.
  const auto step_at_or = [](double value, bool above) {
    const double power = std::pow(10.0, std::floor(std::log10(value)));
    const double lead = value / power;
    if (above) return power * (lead <= 1.0 ? 1.0 : lead <= 2.0 ? 2.0 : lead <= 5.0 ? 5.0 : 10.0);
    return power * (lead >= 5.0 ? 5.0 : lead >= 2.0 ? 2.0 : 1.0);
  };
  const double low = step_at_or(std::max(latency.min_s() * 0.98, 1e-6), false);
  const double high = std::max(step_at_or(std::max(latency.max_s() * 1.02, 1e-6), true), low * 2.0);
  const double log_low = std::log10(low), log_span = std::log10(high) - log_low;
  const auto x_of = [&](double seconds) {
    const double part = (std::log10(std::max(seconds, 1e-6)) - log_low) / log_span;
    return kLeft + std::clamp(part, 0.0, 1.0) * (kPlotRight - kLeft);
  };

  constexpr int kBars = 60;
  std::array<double, kBars> share{};
  double most = 0;
  for (std::size_t i = 0; i < kBars; ++i) {
    const double from = std::pow(10.0, log_low + log_span * static_cast<double>(i) / kBars);
    const double to = std::pow(10.0, log_low + log_span * static_cast<double>(i + 1) / kBars);
    share[i] =
        100.0 * static_cast<double>(latency.count_between(from, to)) / static_cast<double>(latency.count());
    most = std::max(most, share[i]);
  }
  const double step = round_step(most, 4), top = std::max(step, std::ceil(most / step) * step);

  std::string s = svg::begin(kWidth, kHeight, "latency histogram, logarithmic time axis") +
                  vertical_axis(top, "% of ticks");
  for (std::size_t i = 0; i < kBars; ++i) {
    if (share[i] <= 0) continue;
    const double width = (kPlotRight - kLeft) / kBars;
    // Rare slow ticks are what a reader looks for: no bar is thinner than can be seen.
    const double height = std::max(1.5, share[i] / top * (kPlotBottom - kTop));
    s += "<rect class=\"bar\" x=\"" + coordinate(kLeft + width * static_cast<double>(i) + 0.5) + "\" y=\"" +
         coordinate(kPlotBottom - height) + "\" width=\"" + coordinate(width - 1) + "\" height=\"" +
         coordinate(height) + "\"/>";
  }
  const int decades = static_cast<int>(std::ceil(log_span));
  for (int power = -6; power <= 3; ++power) {
    for (const double lead : {1.0, 2.0, 5.0}) {
      if (decades > 3 && lead != 1.0) continue;
      const double value = lead * std::pow(10.0, power);
      if (value < low * 0.999 || value > high * 1.001) continue;
      s += line("tick", x_of(value), kPlotBottom, x_of(value), kPlotBottom + 5);
      s += label("mid", x_of(value), kPlotBottom + 18, short_number(value * 1e3));
    }
  }
  s += label("mid unit", (kLeft + kPlotRight) / 2, kHeight - 5, "latency (ms)");

  // Marks; their texts are pushed apart where they would touch.
  double free_from = kLeft - 100;
  const std::array<std::pair<const char*, double>, 3> marks{
      {{"p50 ", latency.quantile_s(0.5)}, {"p99 ", latency.quantile_s(0.99)}, {"max ", latency.max_s()}}};
  std::array<double, 3> text_x{};
  constexpr double kTextWidth = 92;
  for (std::size_t i = 0; i < 3; ++i) {
    text_x[i] = std::max(x_of(marks[i].second), free_from);
    free_from = text_x[i] + kTextWidth;
  }
  double latest = kPlotRight - 36;
  for (std::size_t i = 3; i-- > 0; latest = text_x[i] - kTextWidth) text_x[i] = std::min(text_x[i], latest);
  for (std::size_t i = 0; i < 3; ++i) {
    const double x = x_of(marks[i].second);
    s += line("mark", x, kTop - 4, x, kPlotBottom);
    s += label("mid strong", text_x[i], kTop - 10, marks[i].first + duration_text(marks[i].second));
  }
  return s + "</svg>";
}

std::string step_chart_svg(const StepChart& chart) {
  if (chart.value.empty() || chart.start_s.size() != chart.value.size()) return nothing_measured(chart.unit);
  const double last_width =
      chart.start_s.size() > 1 ? chart.start_s.back() - chart.start_s[chart.start_s.size() - 2] : 1.0;
  const double end_s = chart.start_s.back() + last_width;
  const double most = std::max(*std::max_element(chart.value.begin(), chart.value.end()), chart.nominal);
  const double step = round_step(std::max(most, 1e-9) * 1.05, 4);
  const double top = std::max(step, std::ceil(most * 1.05 / step) * step);
  const auto x_of = [&](double t) { return kLeft + t / end_s * (kPlotRight - kLeft); };
  const auto y_of = [&](double v) { return kPlotBottom - std::max(v, 0.0) / top * (kPlotBottom - kTop); };

  std::string s = svg::begin(kWidth, kHeight, chart.unit + " over time") + vertical_axis(top, chart.unit);
  const double step_s = round_step(end_s, 6);
  for (double t = 0; t <= end_s * 1.0001; t += step_s) {
    s += line("tick", x_of(t), kPlotBottom, x_of(t), kPlotBottom + 5);
    s += label("mid", x_of(t), kPlotBottom + 18, short_number(t));
  }
  s += label("mid unit", (kLeft + kPlotRight) / 2, kHeight - 5, "time (s)");
  std::string path;
  for (std::size_t i = 0; i < chart.value.size(); ++i) {
    const double to = i + 1 < chart.start_s.size() ? chart.start_s[i + 1] : end_s;
    const std::string y = coordinate(y_of(chart.value[i]));
    path.append(i == 0 ? "M" : "L").append(coordinate(x_of(chart.start_s[i]))).append(" ").append(y);
    path.append("L").append(coordinate(x_of(to))).append(" ").append(y);
  }
  const std::string base = coordinate(kPlotBottom);
  s += "<path class=\"area\" d=\"" + path + "L" + coordinate(x_of(end_s)) + " " + base + "L" +
       coordinate(kLeft) + " " + base + "Z\"/><path class=\"curve\" d=\"" + path + "\"/>";
  if (chart.nominal > 0) {
    s += line("nominal", kLeft, y_of(chart.nominal), kPlotRight, y_of(chart.nominal));
    s +=
        label("end strong", kPlotRight, y_of(chart.nominal) - 6, "nominal " + short_number(chart.nominal, 2));
  }
  return s + "</svg>";
}

}  // namespace glint
