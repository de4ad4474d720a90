// SPDX-License-Identifier: MIT
// The worst seed decides, but for goals that say otherwise.
#include "benchmarks/identity/verdicts.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <optional>

namespace glint::identity {

std::vector<const BenchmarkScene*> scenes_of(std::span<const SceneRun> runs) {
  std::vector<const BenchmarkScene*> scenes;
  for (const SceneRun& run : runs)
    if (std::find(scenes.begin(), scenes.end(), run.scene) == scenes.end()) scenes.push_back(run.scene);
  return scenes;
}

std::vector<double> values_of(std::span<const SceneRun> runs, const BenchmarkScene& scene,
                              const Figure& figure, IdentityResult SceneRun::*tracker) {
  std::vector<double> values;
  for (const SceneRun& run : runs)
    if (run.scene == &scene) values.push_back(figure.of(run.*tracker));
  return values;
}

Spread spread_of(const Figure& figure, std::vector<double> values) {
  if (values.empty()) return {};
  std::sort(values.begin(), values.end());
  const std::size_t middle = values.size() / 2;
  const double median = values.size() % 2 == 1 ? values[middle] : 0.5 * (values[middle - 1] + values[middle]);
  return {median, figure.more_is_better ? values.front() : values.back()};
}

namespace {

// 97.5 % quantiles of Student's t for 1, 2, ... degrees of freedom.
constexpr std::array kStudent{12.706, 4.303, 3.182, 2.776, 2.571, 2.447, 2.365, 2.306, 2.262};

/// How far 1 lies outside the 95 % band of the mean over the seeds. A calibration error is the same all
/// through a run, so one run says little about it however long it is; runs are independent of each other.
double outside_of_seeds(const std::vector<double>& means) {
  const auto count = static_cast<double>(means.size());
  double mean = 0.0, sum2 = 0.0;
  for (const double value : means) mean += value / count;
  for (const double value : means) sum2 += (value - mean) * (value - mean);
  const double quantile = kStudent[std::min(means.size() - 2, kStudent.size() - 1)];
  const double half_width = quantile * std::sqrt(sum2 / (count - 1.0) / count);
  return std::max(0.0, std::abs(mean - 1.0) - half_width);
}

/// With a calibration error, the honesty of covariances over all seeds in place of that of single runs.
std::optional<Spread> honesty_over_seeds(std::span<const SceneRun> runs, const BenchmarkScene& scene,
                                         IdentityResult SceneRun::*tracker) {
  if (scene.calibration_error_px == 0.0) return std::nullopt;
  std::vector<double> means;
  for (const SceneRun& run : runs) {
    if (run.scene != &scene || (run.*tracker).nees.samples == 0) continue;
    if ((run.*tracker).covariance_faults > 0) return std::nullopt;  // which count as infinite
    means.push_back((run.*tracker).nees.mean);
  }
  if (means.size() < 2) return std::nullopt;
  const double outside = outside_of_seeds(means);
  return Spread{outside, outside};
}

}  // namespace

std::vector<Verdict> verdicts(std::span<const SceneRun> runs) {
  std::vector<Verdict> all;
  for (const BenchmarkScene* scene : scenes_of(runs)) {
    for (const Goal& goal : scene->goals) {
      const Figure& wanted = figure(goal.figure);
      const auto spread = [&](IdentityResult SceneRun::*tracker) {
        if (goal.figure == "nees_outside") {
          if (const auto over_seeds = honesty_over_seeds(runs, *scene, tracker)) return *over_seeds;
        }
        std::vector<double> values = values_of(runs, *scene, wanted, tracker);
        if (goal.relative_to.empty()) return spread_of(wanted, std::move(values));
        const std::vector<double> others = values_of(runs, find_scene(goal.relative_to), wanted, tracker);
        if (others.size() != values.size()) return Spread{0.0, std::numeric_limits<double>::quiet_NaN()};
        for (std::size_t i = 0; i < values.size(); ++i) values[i] /= others[i];
        return spread_of(wanted, std::move(values));
      };
      Verdict verdict{scene, &goal, spread(&SceneRun::glint), spread(&SceneRun::plain), false};
      const double judged = goal.median ? verdict.glint.median : verdict.glint.worst;
      verdict.pass = wanted.more_is_better ? judged >= goal.limit : judged <= goal.limit;
      all.push_back(verdict);
    }
  }
  return all;
}

}  // namespace glint::identity
