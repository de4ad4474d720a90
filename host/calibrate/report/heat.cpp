// SPDX-License-Identifier: MIT
// Linear between five colours.
#include "host/calibrate/report/heat.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>

#include "host/page/page_text.hpp"
#include "host/page/svg.hpp"

namespace glint {
namespace {

constexpr int kSteps = 48;
constexpr std::array<std::array<double, 3>, 5> kStops{
    {{38, 84, 140}, {52, 148, 160}, {150, 196, 110}, {240, 190, 70}, {216, 78, 44}}};

}  // namespace

std::string heat_colour(double share) {
  const double part = std::isfinite(share) ? std::clamp(share, 0.0, 1.0) : 1.0;
  const double at = std::round(part * kSteps) / kSteps * static_cast<double>(kStops.size() - 1);
  const std::size_t from = std::min(static_cast<std::size_t>(at), kStops.size() - 2);
  const double beyond = at - static_cast<double>(from);
  std::array<unsigned, 3> rgb{};
  for (std::size_t i = 0; i < 3; ++i)
    rgb[i] =
        static_cast<unsigned>(std::lround((1 - beyond) * kStops[from][i] + beyond * kStops[from + 1][i]));
  std::array<char, 8> text{};
  std::snprintf(text.data(), text.size(), "#%02x%02x%02x", rgb[0] & 255u, rgb[1] & 255u, rgb[2] & 255u);
  return text.data();
}

double round_top(double value) {
  if (!(value > 0) || !std::isfinite(value)) return 1.0;
  const double power = std::pow(10.0, std::floor(std::log10(value)));
  for (const double lead : {1.0, 1.5, 2.0, 3.0, 4.0, 5.0, 6.0, 8.0})
    if (lead * power >= value * 0.9999) return lead * power;
  return 10.0 * power;
}

std::string heat_scale_svg(double x, double y, double width, double top, const std::string& unit) {
  std::string s;
  const double step = width / kSteps;
  for (int i = 0; i < kSteps; ++i) {
    s += svg::rectangle("heat", x + step * i, y, step + 0.3, 10,
                        "fill:" + heat_colour((i + 0.5) / static_cast<double>(kSteps)));
  }
  const double every = round_step(top, 4);
  for (double v = 0; v <= top * 1.0001; v += every) {
    const double at = x + v / top * width;
    s += svg::line("tick", at, y + 10, at, y + 14);
    s += svg::label("mid", at, y + 26, short_number(v, 4));
  }
  return s + svg::label("start unit", x + width + 12, y + 10, unit);
}

}  // namespace glint
