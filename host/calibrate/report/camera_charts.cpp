// SPDX-License-Identifier: MIT
// Residual maps, coverage and histograms.
#include "host/calibrate/report/camera_charts.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "host/calibrate/report/heat.hpp"
#include "host/page/page_text.hpp"
#include "host/page/svg.hpp"

namespace glint {
namespace {

constexpr double kWidth = 520;
constexpr double kEdge = 1;    // around an image, for its frame
constexpr double kBelow = 44;  // for scale and key

double quantile(std::vector<double> values, double share) {
  if (values.empty()) return 0.0;
  const auto at =
      values.begin() + static_cast<std::ptrdiff_t>(share * static_cast<double>(values.size() - 1));
  std::nth_element(values.begin(), at, values.end());
  return *at;
}

std::string arrow(const Eigen::Vector2d& from, const Eigen::Vector2d& along) {
  const double length = along.norm();
  if (!(length > 0.3)) return {};
  const Eigen::Vector2d to = from + along, back = along / length * std::min(4.0, 0.5 * length);
  const Eigen::Vector2d side(-0.6 * back.y(), 0.6 * back.x());
  const auto at = [](const Eigen::Vector2d& p) {
    return svg::coordinate(p.x()) + " " + svg::coordinate(p.y());
  };
  return "M" + at(from) + "L" + at(to) + "M" + at(to - back + side) + "L" + at(to) + "L" +
         at(to - back - side);
}

}  // namespace

ResidualGrid::ResidualGrid(std::span<const PixelResidual> residuals, std::uint32_t width_px,
                           std::uint32_t height_px)
    : cells_(kColumns * kRows), width_px_(std::max(width_px, 1u)), height_px_(std::max(height_px, 1u)) {
  std::vector<std::array<std::vector<double>, 3>> values(cells_.size());  // x, y, length
  for (const PixelResidual& residual : residuals) {
    if (residual.outlier || !residual.pixel.allFinite() || !residual.residual_px.allFinite()) continue;
    const auto cell = [](double place, double extent, std::size_t cells) {
      const double at = std::floor((place + 0.5) / extent * static_cast<double>(cells));
      return static_cast<std::size_t>(std::clamp(at, 0.0, static_cast<double>(cells - 1)));
    };
    auto& at = values[cell(residual.pixel.y(), height_px_, kRows) * kColumns +
                      cell(residual.pixel.x(), width_px_, kColumns)];
    at[0].push_back(residual.residual_px.x());
    at[1].push_back(residual.residual_px.y());
    at[2].push_back(residual.residual_px.norm());
  }
  for (std::size_t i = 0; i < cells_.size(); ++i) {
    cells_[i].count = values[i][0].size();
    cells_[i].shift_px = {quantile(std::move(values[i][0]), 0.5), quantile(std::move(values[i][1]), 0.5)};
    cells_[i].length_px = quantile(std::move(values[i][2]), 0.5);
  }
}

ResidualScale residual_scale(std::span<const ResidualGrid> cameras) {
  std::vector<double> length, shift, cell_width;
  for (const ResidualGrid& grid : cameras) {
    cell_width.push_back(grid.width_px() / static_cast<double>(ResidualGrid::kColumns));
    for (std::size_t row = 0; row < ResidualGrid::kRows; ++row) {
      for (std::size_t column = 0; column < ResidualGrid::kColumns; ++column) {
        if (grid.count(column, row) < ResidualGrid::kLeast) continue;
        length.push_back(grid.median_px(column, row));
        shift.push_back(grid.shift_px(column, row).norm());
      }
    }
  }
  ResidualScale scale;
  if (length.empty()) return scale;
  scale.top_px = round_top(1.1 * quantile(length, 0.98));
  scale.arrow_px = round_top(0.8 * quantile(shift, 0.98));
  // Such an arrow is about as long as a cell, in round numbers.
  scale.magnified = round_top(0.7 * quantile(cell_width, 0.5) / scale.arrow_px);
  return scale;
}

std::string residual_map_svg(const ResidualGrid& grid, const ResidualScale& scale) {
  const double unit = (kWidth - 2 * kEdge) / grid.width_px(), height = unit * grid.height_px();
  const double cell_w = (kWidth - 2 * kEdge) / ResidualGrid::kColumns, cell_h = height / ResidualGrid::kRows;
  std::string s = svg::begin(kWidth, height + 2 * kEdge + kBelow, "residuals over the image"), arrows;
  for (std::size_t row = 0; row < ResidualGrid::kRows; ++row) {
    for (std::size_t column = 0; column < ResidualGrid::kColumns; ++column) {
      const double x = kEdge + cell_w * static_cast<double>(column),
                   y = kEdge + cell_h * static_cast<double>(row);
      const std::uint64_t count = grid.count(column, row);
      const Eigen::Vector2d& shift = grid.shift_px(column, row);
      if (count < ResidualGrid::kLeast) {
        s += svg::rectangle("cell", x, y, cell_w, cell_h, "fill:none", std::to_string(count) + " samples");
        continue;
      }
      s += svg::rectangle(
          "cell", x, y, cell_w, cell_h, "fill:" + heat_colour(grid.median_px(column, row) / scale.top_px),
          short_number(grid.median_px(column, row), 3) + " px, shifted by " + short_number(shift.x(), 3) +
              ", " + short_number(shift.y(), 3) + " px, " + std::to_string(count) + " samples");
      arrows += arrow({x + cell_w / 2, y + cell_h / 2}, shift * scale.magnified * unit);
    }
  }
  if (!arrows.empty()) s += svg::path("halo", arrows) + svg::path("arrow", arrows);
  const double below = height + 2 * kEdge + 8;
  s += svg::rectangle("frame", kEdge, kEdge, kWidth - 2 * kEdge, height, "fill:none");
  s += heat_scale_svg(8, below, 210, scale.top_px, "px, median");
  const double key = scale.arrow_px * scale.magnified * unit;
  s += svg::path("key", arrow({330, below + 7}, {key, 0}));
  return s +
         svg::label("start", 330 + key + 10, below + 11,
                    "shift of " + short_number(scale.arrow_px, 4) + " px") +
         "</svg>";
}

std::string coverage_svg(const CoverageGrid& grid, double height_over_width) {
  constexpr std::size_t kColumns = CoverageGrid::kColumns, kRows = CoverageGrid::kRows;
  const double height = (kWidth - 2 * kEdge) * height_over_width;
  const double cell_w = (kWidth - 2 * kEdge) / kColumns, cell_h = height / kRows;
  std::uint64_t most = 1;
  for (std::size_t row = 0; row < kRows; ++row)
    for (std::size_t column = 0; column < kColumns; ++column) most = std::max(most, grid.count(column, row));
  std::string s = svg::begin(kWidth, height + 2 * kEdge, "number of samples over the image");
  for (std::size_t row = 0; row < kRows; ++row) {
    for (std::size_t column = 0; column < kColumns; ++column) {
      const std::uint64_t count = grid.count(column, row);
      const double x = kEdge + cell_w * static_cast<double>(column),
                   y = kEdge + cell_h * static_cast<double>(row);
      const double share = std::sqrt(static_cast<double>(count) / static_cast<double>(most));
      s += svg::rectangle("cell", x, y, cell_w, cell_h,
                          count == 0
                              ? "fill:none"
                              : "fill:var(--accent);fill-opacity:" + short_number(0.08 + 0.42 * share, 2));
      s += svg::label(count == 0 ? "mid bad" : "mid count", x + cell_w / 2, y + cell_h / 2 + 6,
                      std::to_string(count));
    }
  }
  return s + svg::rectangle("frame", kEdge, kEdge, kWidth - 2 * kEdge, height, "fill:none") + "</svg>";
}

std::string histogram_svg(const Histogram& histogram) {
  constexpr double kHeight = 230, kLeft = 46, kRight = 16, kTop = 30, kBottom = 42;
  const double width = histogram.width, plot_right = width - kRight;
  constexpr double kPlotBottom = kHeight - kBottom;
  constexpr std::size_t kBars = 40;
  std::string s = svg::begin(width, kHeight, histogram.what);
  if (histogram.values.empty() && histogram.outline.empty())
    return s + svg::label("mid", width / 2, kHeight / 2, "nothing measured") + "</svg>";
  const double span = histogram.high - histogram.low;
  const auto shares_of = [&](const std::vector<double>& values) {
    std::array<double, kBars> shares{};
    for (const double value : values) {
      if (!std::isfinite(value)) continue;
      const double at = std::floor((value - histogram.low) / span * kBars);
      shares[static_cast<std::size_t>(std::clamp(at, 0.0, static_cast<double>(kBars - 1)))] +=
          100.0 / static_cast<double>(values.size());
    }
    return shares;
  };
  const auto bars = shares_of(histogram.values), outline = shares_of(histogram.outline);
  const double most = std::max(*std::max_element(bars.begin(), bars.end()),
                               *std::max_element(outline.begin(), outline.end()));
  const double step = round_step(most, 4), top = std::max(step, std::ceil(most / step) * step);
  const auto x_of = [&](double value) {
    return kLeft + std::clamp((value - histogram.low) / span, 0.0, 1.0) * (plot_right - kLeft);
  };
  const auto y_of = [&](double share) { return kPlotBottom - share / top * (kPlotBottom - kTop); };
  for (double v = 0; v <= top * 1.0001; v += step) {
    s += svg::line(v == 0 ? "axis" : "grid", kLeft, y_of(v), plot_right, y_of(v));
    s += svg::label("end", kLeft - 6, y_of(v) + 4, short_number(v, 2));
  }
  s += svg::label("start unit", 4, 14, "% of samples");
  const double bar = (plot_right - kLeft) / kBars;
  std::string steps;
  for (std::size_t i = 0; i < kBars; ++i) {
    const double x = kLeft + bar * static_cast<double>(i);
    if (bars[i] > 0) {
      const double high = std::max(1.0, kPlotBottom - y_of(bars[i]));
      s += svg::rectangle("bar", x + 0.5, kPlotBottom - high, bar - 1, high);
    }
    const std::string y = svg::coordinate(y_of(outline[i]));
    steps += (i == 0 ? "M" : "L") + svg::coordinate(x) + " " + y + "L" + svg::coordinate(x + bar) + " " + y;
  }
  if (!histogram.outline.empty()) s += svg::path("outline", steps);
  const double every = round_step(span, width / 75);
  for (double v = std::ceil(histogram.low / every - 1e-6) * every; v <= histogram.high + every * 1e-6;
       v += every) {
    s += svg::line("tick", x_of(v), kPlotBottom, x_of(v), kPlotBottom + 5);
    s += svg::label("mid", x_of(v), kPlotBottom + 18, short_number(v, 4));
  }
  s += svg::label("mid unit", (kLeft + plot_right) / 2, kHeight - 6, histogram.unit);
  double free_from = kLeft + 50;  // the axis' words stand before
  for (const auto& [words, value] : histogram.marks) {
    s += svg::line("mark", x_of(value), kTop - 4, x_of(value), kPlotBottom);
    const double half = 3.6 * static_cast<double>(words.size());
    const double x = std::min(std::max(x_of(value), free_from + half), plot_right - half);
    s += svg::label("mid strong", x, kTop - 10, words);
    free_from = x + half + 8;
  }
  return s + "</svg>";
}

}  // namespace glint
