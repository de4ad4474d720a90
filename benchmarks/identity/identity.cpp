// SPDX-License-Identifier: MIT
// The identity benchmark: runs glint, makes scenes for other trackers, scores their points
// (docs/identity-benchmark.md).
#include <cstdio>
#include <exception>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include <CLI/CLI.hpp>

#include "benchmarks/identity/cost.hpp"
#include "benchmarks/identity/generate.hpp"
#include "benchmarks/identity/points_file.hpp"
#include "benchmarks/identity/results_text.hpp"
#include "benchmarks/identity/run_scene.hpp"
#include "benchmarks/identity/scenes.hpp"
#include "host/base/error.hpp"
#include "host/files/text_file.hpp"
#include "host/match/matcher.hpp"

namespace glint::identity {
namespace {

constexpr int kFailed = 1, kWrongUsage = 2;

struct Arguments {
  std::vector<std::string> scenes;
  std::uint64_t seeds = 5, seed = 1, ticks = 0;
  unsigned jobs = 1, most_looks = MatchOptions{}.most_looks;
  std::string json, table, scene, folder, points;
};

void list() {
  for (const BenchmarkScene& scene : benchmark_scenes())
    std::printf("%-18s %6llu frames  %s\n", scene.name.c_str(), static_cast<unsigned long long>(scene.ticks),
                scene.text.c_str());
}

void run(const Arguments& a) {
  std::vector<const BenchmarkScene*> scenes;
  for (const std::string& name : a.scenes) scenes.push_back(&find_scene(name));
  if (scenes.empty())
    for (const BenchmarkScene& scene : benchmark_scenes()) scenes.push_back(&scene);
  const std::vector<SceneRun> runs = run_scenes(scenes, a.seeds, a.ticks, a.jobs, [](const SceneRun& done) {
    std::fprintf(stderr, "%s\n", progress_line(done).c_str());
  });
  const std::string page = results_markdown(runs);
  if (!a.json.empty()) write_text_file(a.json, results_json(runs), true);
  if (a.table.empty()) {
    std::fputs(page.c_str(), stdout);
  } else {
    write_text_file(a.table, page, true);
  }
}

void cost(const Arguments& a) {
  constexpr std::uint32_t kSizes[][2] = {{4, 20}, {4, 50}, {4, 100}, {4, 200}, {16, 100}, {32, 200}};
  std::fputs(cost_head().c_str(), stdout);
  for (const auto& [cameras, markers] : kSizes) {
    std::fputs(cost_row(cost_of(cameras, markers, a.ticks == 0 ? 300 : a.ticks, a.most_looks)).c_str(),
               stdout);
    std::fflush(stdout);
  }
}

ChosenScene chosen_scene(const Arguments& a) {
  const BenchmarkScene& scene = find_scene(a.scene);
  return {&scene, a.seed, a.ticks == 0 ? scene.ticks : a.ticks};
}

void score(const Arguments& a) {
  const std::filesystem::path file = std::filesystem::path(a.scene) / "scene.json";
  const ChosenScene chosen = std::filesystem::exists(file) ? read_scene_file(file) : chosen_scene(a);
  const Scene scene(chosen.scene->options_with(chosen.seed));
  PointsFile points(a.points, chosen.ticks, scene.cameras());
  std::fprintf(stderr, "%s: scene %s, seed %llu, %llu frames; beyond places and ids the file tells %s\n",
               a.points.c_str(), chosen.scene->name.c_str(), static_cast<unsigned long long>(chosen.seed),
               static_cast<unsigned long long>(chosen.ticks),
               points.extras().empty() ? "nothing" : points.extras().c_str());
  IdentityScore score(scene);
  std::vector<IdentitySample> samples;
  for (std::uint64_t tick = 0; tick < chosen.ticks; ++tick) {
    points.take(tick, samples);
    score.add(tick, samples);
  }
  std::fputs(result_lines(score.result()).c_str(), stdout);
}

int main_of(int argc, char** argv) {
  CLI::App app("The identity benchmark of multi-camera marker trackers");
  app.require_subcommand(1);
  Arguments a;
  app.add_subcommand("list", "the scenes")->callback(list);
  CLI::App* runs = app.add_subcommand("run", "glint and the plain method on scenes, against the goals");
  runs->add_option("SCENE", a.scenes, "scenes; none: all");
  runs->add_option("--seeds", a.seeds, "seeds 1 to N of each")
      ->capture_default_str()
      ->check(CLI::Range(1, 1000));
  runs->add_option("--ticks", a.ticks, "frames of each run; 0: as many as the scene has");
  runs->add_option("--jobs", a.jobs, "runs at a time")->capture_default_str()->check(CLI::Range(1, 256));
  runs->add_option("--json", a.json, "write every figure of every run to this file");
  runs->add_option("--table", a.table, "write the page to this file, not to standard output");
  runs->callback([&a] { run(a); });
  CLI::App* costs = app.add_subcommand("cost", "processor time from blobs to tracks, by cameras and markers");
  costs->add_option("--ticks", a.ticks, "frames of each; 0: 300");
  costs->add_option("--looks", a.most_looks, "match.most_looks")->capture_default_str();
  costs->callback([&a] { cost(a); });
  CLI::App* generates = app.add_subcommand("generate", "write a scene for another tracker");
  generates->add_option("SCENE", a.scene, "name of the scene")->required();
  generates->add_option("FOLDER", a.folder, "where to; new or empty")->required();
  generates->callback([&a] { generate(chosen_scene(a), a.folder); });
  CLI::App* scores = app.add_subcommand("score", "score the points of another tracker");
  scores->add_option("SCENE", a.scene, "folder that generate made, or the name of a scene")->required();
  scores->add_option("POINTS", a.points, "CSV file: tick,id,x_m,y_m,z_m and more if known")->required();
  scores->callback([&a] { score(a); });
  for (CLI::App* command : {generates, scores}) {
    command->add_option("--seed", a.seed, "seed of a scene given by name")->capture_default_str();
    command->add_option("--ticks", a.ticks, "frames of a scene given by name; 0: as many as it has");
  }
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    return app.exit(error) == 0 ? 0 : kWrongUsage;
  }
  return 0;
}

}  // namespace
}  // namespace glint::identity

int main(int argc, char** argv) {
  try {
    return glint::identity::main_of(argc, argv);
  } catch (const glint::UsageError& error) {
    std::fprintf(stderr, "identity: %s\n", error.what());
    return glint::identity::kWrongUsage;
  } catch (const std::exception& error) {
    std::fprintf(stderr, "identity: %s\n", error.what());
    return glint::identity::kFailed;
  }
}
