// SPDX-License-Identifier: MIT
// Layout, slices of expected error, and the graph of common samples.
#include "host/calibrate/report/rig_charts.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "host/calibrate/report/heat.hpp"
#include "host/page/page_text.hpp"
#include "host/page/svg.hpp"

namespace glint {
namespace {

constexpr double kWidth = 560, kMostHeight = 520;
constexpr double kScaleHeight = 46;
constexpr std::size_t kGraphCameras = 8;

std::string title_of(PlanAxes axes, const char* what) {
  return std::string(what) + (axes == PlanAxes::FromAbove ? ", seen from above" : ", seen from the side");
}

std::string sample_dots(const PlanView& view, std::span<const Eigen::Vector3d> samples_in_world) {
  std::string dots;
  for (const Eigen::Vector3d& p : samples_in_world)
    if (p.allFinite()) dots += "M" + view.at(p) + "h0";
  return dots.empty() ? "" : svg::path("samples", dots);
}

/// Cells of one colour that lie side by side become one rectangle.
std::string cells(const PlanView& view, const ExpectedErrorMap& map, double top_m) {
  std::string s;
  const Eigen::Vector3d right = 0.5 * map.step_m * map.slice.along, up = 0.5 * map.step_m * map.slice.up;
  for (std::size_t row = 0; row < map.rows; ++row) {
    for (std::size_t begin = 0, end = 0; begin < map.columns; begin = end) {
      const double value = map.at(begin, row);
      end = begin + 1;
      if (std::isnan(value)) continue;
      const std::string colour = heat_colour(value / top_m);
      while (end < map.columns && !std::isnan(map.at(end, row)) &&
             heat_colour(map.at(end, row) / top_m) == colour)
        ++end;
      const Eigen::Vector2d from = view(map.centre_in_world(begin, row) - right + up);
      const Eigen::Vector2d to = view(map.centre_in_world(end - 1, row) + right - up);
      // A hair wider, or the gaps between neighbours show.
      s += svg::rectangle("heat", from.x(), from.y(), to.x() - from.x() + 0.4, to.y() - from.y() + 0.4,
                          "fill:" + colour);
    }
  }
  return s;
}

std::uint64_t most_common(const Overlap& overlap) {
  std::uint64_t most = 1;
  for (std::size_t a = 0; a < overlap.cameras(); ++a)
    for (std::size_t b = a + 1; b < overlap.cameras(); ++b) most = std::max(most, overlap.ticks(a, b));
  return most;
}

std::string overlap_graph(const Overlap& overlap, std::span<const std::string> names) {
  constexpr double kHeight = 290, kRadius = 105;
  const std::size_t n = overlap.cameras();
  const std::uint64_t most = most_common(overlap);
  const auto place = [&](std::size_t i, double radius) -> Eigen::Vector2d {
    const double angle = 2.0 * std::numbers::pi * (static_cast<double>(i) + 0.5) / static_cast<double>(n);
    return {kWidth / 2 + radius * std::sin(angle), kHeight / 2 - radius * std::cos(angle)};
  };
  std::string lines, labels, nodes;
  for (std::size_t a = 0; a < n; ++a) {
    for (std::size_t b = a + 1; b < n; ++b) {
      const Eigen::Vector2d from = place(a, kRadius), to = place(b, kRadius);
      const std::uint64_t common = overlap.ticks(a, b);
      if (common == 0) {
        lines += svg::line("nominal", from.x(), from.y(), to.x(), to.y());
        continue;
      }
      const double thick = 1.0 + 7.0 * std::sqrt(static_cast<double>(common) / static_cast<double>(most));
      lines += svg::path("link",
                         "M" + svg::coordinate(from.x()) + " " + svg::coordinate(from.y()) + "L" +
                             svg::coordinate(to.x()) + " " + svg::coordinate(to.y()),
                         "stroke-width:" + svg::coordinate(thick));
      // Off the middle, where lines across the circle cross.
      const Eigen::Vector2d at = from + (b - a == 1 || (a == 0 && b == n - 1) ? 0.5 : 0.36) * (to - from);
      labels += svg::label("mid name", at.x(), at.y() + 4, std::to_string(common));
    }
  }
  for (std::size_t i = 0; i < n; ++i) {
    const Eigen::Vector2d p = place(i, kRadius), out = place(i, kRadius + 16) - p;
    const char* kind = out.x() > 4 ? "start name" : out.x() < -4 ? "end name" : "mid name";
    nodes +=
        svg::circle("eye", p.x(), p.y(), 9, names[i] + ": " + std::to_string(overlap.ticks(i, i)) + " ticks");
    nodes += svg::label(kind, p.x() + out.x(), p.y() + 4 + 1.3 * out.y(), names[i]);
  }
  return svg::begin(kWidth, kHeight, "common samples of each two cameras") + lines + labels + nodes +
         "</svg>";
}

std::string overlap_table(const Overlap& overlap, std::span<const std::string> names) {
  constexpr double kLeft = 76, kTop = 66, kPlot = kWidth - kLeft - 44;
  const std::size_t n = overlap.cameras();
  const double cell_w = kPlot / static_cast<double>(n),
               cell_h = std::max(12.0, 240.0 / static_cast<double>(n));
  const double bottom = kTop + cell_h * static_cast<double>(n);
  const std::uint64_t most = most_common(overlap);
  std::string s = svg::begin(kWidth, bottom + kScaleHeight, "common samples of each two cameras");
  for (std::size_t a = 0; a < n; ++a) {
    const double y = kTop + cell_h * static_cast<double>(a);
    s += svg::label("end", kLeft - 6, y + cell_h / 2 + 4, names[a]);
    const double x = kLeft + cell_w * (static_cast<double>(a) + 0.5);
    s += "<text class=\"start\" transform=\"translate(" + svg::coordinate(x + 4) + " " +
         svg::coordinate(kTop - 6) + ") rotate(-60)\">" + escape_html(names[a]) + "</text>";
    for (std::size_t b = 0; b < n; ++b) {
      const double share = std::sqrt(static_cast<double>(overlap.ticks(a, b)) / static_cast<double>(most));
      std::string style = "fill:var(--accent);fill-opacity:" + short_number(0.1 + 0.9 * share, 2);
      if (a == b) style = "fill:none";
      if (overlap.ticks(a, b) == 0) style = "fill:var(--refuse)";
      s += svg::rectangle(
          "cell", kLeft + cell_w * static_cast<double>(b), y, cell_w, cell_h, style,
          names[a] + " and " + names[b] + ": " + std::to_string(overlap.ticks(a, b)) + " ticks");
    }
  }
  s += svg::label("start", kLeft, bottom + 20,
                  "the stronger the colour, the more samples (most: " + std::to_string(most) + ")");
  return s + svg::label("start", kLeft, bottom + 38, "red: none; point at a cell to see its number") +
         "</svg>";
}

}  // namespace

std::string layout_svg(PlanAxes axes, const Calibration& calibration,
                       std::span<const Eigen::Vector3d> samples_in_world, const Eigen::Vector3d& low_in_world,
                       const Eigen::Vector3d& high_in_world) {
  const PlanView view(axes, low_in_world, high_in_world, kWidth, kMostHeight);
  Eigen::Vector3d middle = 0.5 * (low_in_world + high_in_world);
  double reach_m = 0.0;
  for (const CameraCalibration& camera : calibration.cameras)
    if (camera.world_from_camera.translation.allFinite())
      reach_m = std::max(reach_m, 1.6 * (camera.world_from_camera.translation - middle).norm());
  return svg::begin(view.width(), view.height(), title_of(axes, "cameras and samples")) + view.grid() +
         view.fields_of_view(calibration.cameras, reach_m) + sample_dots(view, samples_in_world) +
         view.axes() + view.cameras(calibration.cameras) + "</svg>";
}

std::string error_slice_svg(PlanAxes axes, const ExpectedErrorMap& map, double top_m,
                            const Calibration& calibration, const Eigen::Vector3d& low_in_world,
                            const Eigen::Vector3d& high_in_world) {
  const PlanView view(axes, low_in_world, high_in_world, kWidth, kMostHeight);
  return svg::begin(view.width(), view.height() + kScaleHeight, title_of(axes, "expected error of a point")) +
         view.grid() + cells(view, map, top_m) + view.axes() + view.cameras(calibration.cameras) +
         heat_scale_svg(60, view.height() + 6, view.width() - 260, 1e3 * top_m, "mm rms (red: or more)") +
         "</svg>";
}

std::string overlap_svg(const Overlap& overlap, std::span<const std::string> names) {
  return overlap.cameras() <= kGraphCameras ? overlap_graph(overlap, names) : overlap_table(overlap, names);
}

}  // namespace glint
