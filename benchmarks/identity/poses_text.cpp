// SPDX-License-Identifier: MIT
// One column for each figure of poses.
#include "benchmarks/identity/poses_text.hpp"

#include <algorithm>
#include <array>
#include <cstdio>
#include <numbers>
#include <vector>

#include "benchmarks/identity/verdicts.hpp"

namespace glint::identity {
namespace {

struct PoseFigure {
  const char *name, *title;
  int decimals;
  bool more_is_better;
  double (*of)(const PoseResult& poses);  ///< as shown
};

using Poses = const PoseResult&;
constexpr double kDegrees = 180.0 / std::numbers::pi;
constexpr std::array kFigures{
    PoseFigure{"recall", "recall of poses", 5, true, [](Poses p) { return p.recall; }},
    PoseFigure{"rms_mm", "RMS (mm)", 4, false, [](Poses p) { return 1e3 * p.rms_m; }},
    PoseFigure{"worst_mm", "worst (mm)", 3, false, [](Poses p) { return 1e3 * p.max_m; }},
    PoseFigure{"rms_degrees", "RMS (degrees)", 4, false, [](Poses p) { return kDegrees * p.rms_rad; }},
    PoseFigure{"worst_degrees", "worst (degrees)", 3, false, [](Poses p) { return kDegrees * p.max_rad; }},
    PoseFigure{"astray", "poses at no body", 0, false, [](Poses p) { return static_cast<double>(p.astray); }},
    PoseFigure{"silent_swaps", "silent swaps of names", 0, false,
               [](Poses p) { return static_cast<double>(p.silent_swaps); }},
    PoseFigure{"ambiguous_percent", "ambiguous (%)", 3, false,
               [](Poses p) {
                 return p.poses == 0
                            ? 0.0
                            : 100.0 * static_cast<double>(p.ambiguous) / static_cast<double>(p.poses);
               }},
};

std::string median_and_worst(const PoseFigure& figure, std::vector<double> values) {
  std::sort(values.begin(), values.end());
  const std::size_t middle = values.size() / 2;
  const double median = values.size() % 2 == 1 ? values[middle] : 0.5 * (values[middle - 1] + values[middle]);
  char text[96];
  std::snprintf(text, sizeof text, "%.*f / %.*f", figure.decimals, median, figure.decimals,
                figure.more_is_better ? values.front() : values.back());
  return text;
}

}  // namespace

std::string poses_table(std::span<const SceneRun> runs) {
  std::string head = "| scene |", rule = "|---|", rows;
  for (const PoseFigure& figure : kFigures) {
    head += " " + std::string(figure.title) + " |";
    rule += "---|";
  }
  for (const BenchmarkScene* scene : scenes_of(runs)) {
    std::string row = "| " + scene->name + " |";
    std::vector<double> values;
    for (const PoseFigure& figure : kFigures) {
      values.clear();
      for (const SceneRun& run : runs)
        if (run.scene == scene && run.poses) values.push_back(figure.of(*run.poses));
      if (values.empty()) break;
      row += " " + median_and_worst(figure, values) + " |";
    }
    if (!values.empty()) rows += row + "\n";
  }
  return rows.empty() ? "" : head + "\n" + rule + "\n" + rows;
}

nlohmann::ordered_json poses_json(const PoseResult& poses) {
  nlohmann::ordered_json json;
  for (const PoseFigure& figure : kFigures) json[figure.name] = figure.of(poses);
  json["poses"] = poses.poses;
  json["expected"] = poses.expected;
  json["found"] = poses.found;
  return json;
}

}  // namespace glint::identity
