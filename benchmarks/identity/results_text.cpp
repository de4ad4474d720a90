// SPDX-License-Identifier: MIT
// Tables of figures.
#include "benchmarks/identity/results_text.hpp"

#include <algorithm>
#include <array>
#include <cstdio>
#include <string_view>
#include <vector>

#include <nlohmann/json.hpp>

#include "benchmarks/identity/figures.hpp"
#include "benchmarks/identity/poses_text.hpp"
#include "benchmarks/identity/verdicts.hpp"

namespace glint::identity {
namespace {

std::string goal_text(const Verdict& verdict) {
  const Figure& wanted = figure(verdict.goal->figure);
  if (wanted.name == "nees_outside") return "1 within the 95 % band of NEES: off by";
  std::string text = std::string(wanted.title) + (wanted.more_is_better ? " >= " : " <= ");
  if (verdict.goal->relative_to.empty()) return text + shown(wanted, verdict.goal->limit);
  char factor[32];
  std::snprintf(factor, sizeof factor, "%g x ", verdict.goal->limit);
  return text + factor + std::string(verdict.goal->relative_to);
}

std::string spread_text(const Verdict& verdict, const Spread& spread) {
  const Figure& wanted = figure(verdict.goal->figure);
  if (!verdict.goal->relative_to.empty()) {
    char text[64];
    std::snprintf(text, sizeof text, "%.2f / %.2f", spread.median, spread.worst);
    return text;
  }
  return shown(wanted, spread.median, false) + " / " + shown(wanted, spread.worst, false);
}

std::string goals_table(std::span<const SceneRun> runs) {
  std::string text =
      "| scene | goal | glint, median / worst | | plain method, median / worst |\n|---|---|---|---|---|\n";
  const BenchmarkScene* last = nullptr;
  for (const Verdict& verdict : verdicts(runs)) {
    const bool honest_by_default = verdict.goal->figure == "nees_outside";
    text += "| " + (verdict.scene == last ? "" : verdict.scene->name) + " | " + goal_text(verdict) + " | " +
            spread_text(verdict, verdict.glint) + " | " + (verdict.pass ? "pass" : "**miss**") + " | " +
            (honest_by_default ? "no covariance" : spread_text(verdict, verdict.plain)) + " |\n";
    last = verdict.scene;
  }
  return text;
}

std::string figures_table(std::span<const SceneRun> runs, IdentityResult SceneRun::*tracker) {
  constexpr std::array<std::string_view, 17> kColumns{
      "recall",     "ghosts_per_tick", "doubled_per_tick", "mixed",         "silent_swaps", "swaps",
      "fragments",  "returns",         "longest_gap",      "rms",           "worst",        "q999",
      "pair_worst", "ambiguous_share", "predicted_share",  "predicted_rms", "nees"};
  std::string head = "| scene |", rule = "|---|";
  for (const std::string_view name : kColumns) {
    const Figure& column = figure(name);
    head += " " + std::string(column.title) +
            (column.unit.empty() ? "" : " (" + std::string(column.unit) + ")") + " |";
    rule += "---|";
  }
  std::string text = head + "\n" + rule + "\n";
  for (const BenchmarkScene* scene : scenes_of(runs)) {
    text += "| " + scene->name + " |";
    for (const std::string_view name : kColumns) {
      const Figure& column = figure(name);
      const Spread spread = spread_of(column, values_of(runs, *scene, column, tracker));
      text += " " + shown(column, spread.median, false) + " / " + shown(column, spread.worst, false) + " |";
    }
    text += "\n";
  }
  return text;
}

nlohmann::ordered_json figures_json(const IdentityResult& result) {
  nlohmann::ordered_json json;
  for (const Figure& figure : figures()) json[std::string(figure.name)] = figure.of(result);
  json["measured"] = result.measured;
  json["found"] = result.found;
  json["predicted"] = result.predicted;
  json["predicted_of_nothing"] = result.predicted_of_nothing;
  json["mixed_checked"] = result.mixed_checked;
  json["nees_samples"] = result.nees.samples;
  json["covariance_faults"] = result.covariance_faults;
  json["cameras_back"] = result.cameras_back;
  json["pairs"] = result.pairs;
  return json;
}

}  // namespace

std::string results_markdown(std::span<const SceneRun> runs) {
  std::uint64_t seeds = 0;
  double wall_s = 0.0;
  bool whole = true;
  for (const SceneRun& run : runs) {
    seeds = std::max(seeds, run.seed);
    wall_s += run.wall_s;
    whole = whole && run.ticks == run.scene->ticks;
  }
  const std::vector<Verdict> all = verdicts(runs);
  const auto passed = std::count_if(all.begin(), all.end(), [](const Verdict& v) { return v.pass; });
  std::string text =
      "# Identity benchmark: results\n\nMade by `identity run`; [docs/identity-benchmark.md]"
      "(../../docs/identity-benchmark.md) says what is counted and how to run another tracker. ";
  text += "Median and worst over " + std::to_string(seeds) + " seeds; the worst decides. " +
          std::to_string(passed) + " of " + std::to_string(all.size()) + " goals reached; " +
          std::to_string(static_cast<int>(wall_s)) + " s.";
  if (!whole) text += " **Shortened runs: no result of the benchmark.**";
  text += "\n\n## Goals\n\n" + goals_table(runs);
  text += "\n## All figures of glint, median / worst\n\n" + figures_table(runs, &SceneRun::glint);
  text += "\n## All figures of the plain method, median / worst\n\n" + figures_table(runs, &SceneRun::plain);
  std::vector<SceneRun> of_bodies;
  for (const SceneRun& run : runs)
    if (run.poses) of_bodies.push_back(run);
  if (!of_bodies.empty()) {
    text += "\n## glint with the bodies known, median / worst\n\n### Poses\n\n" + poses_table(of_bodies);
    text += "\n### Markers\n\n" + figures_table(of_bodies, &SceneRun::bodies_known);
  }
  return text;
}

std::string results_json(std::span<const SceneRun> runs) {
  nlohmann::ordered_json json = nlohmann::ordered_json::array();
  for (const SceneRun& run : runs) {
    json.push_back({{"scene", run.scene->name},
                    {"seed", run.seed},
                    {"ticks", run.ticks},
                    {"wall_s", run.wall_s},
                    {"glint", figures_json(run.glint)},
                    {"plain", figures_json(run.plain)}});
    if (run.poses) {
      json.back()["bodies_known"] = figures_json(run.bodies_known);
      json.back()["poses"] = poses_json(*run.poses);
    }
  }
  return json.dump(2) + "\n";
}

std::string result_lines(const IdentityResult& result) {
  std::string text;
  for (const Figure& figure : figures()) {
    char line[128];
    std::snprintf(line, sizeof line, "%-28.*s %s\n", static_cast<int>(figure.title.size()),
                  figure.title.data(), shown(figure, figure.of(result)).c_str());
    text += line;
  }
  return text;
}

std::string progress_line(const SceneRun& run) {
  std::string text = run.scene->name + " seed " + std::to_string(run.seed) + ":";
  for (const char* name :
       {"recall", "ghosts_per_tick", "silent_swaps", "longest_gap", "rms", "worst", "nees"}) {
    const Figure& wanted = figure(name);
    text += " " + std::string(wanted.title) + " " + shown(wanted, wanted.of(run.glint)) + ",";
  }
  char seconds[32];
  std::snprintf(seconds, sizeof seconds, " %.1f s", run.wall_s);
  return text + seconds;
}

}  // namespace glint::identity
