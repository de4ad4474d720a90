// SPDX-License-Identifier: MIT
// glint and OpenCV on the same pictures in one process, taking turns; medians and ratios as a Markdown table.
#include <malloc.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <chrono>
#include <cstdio>
#include <fstream>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "benchmarks/glint_contenders.hpp"
#include "benchmarks/opencv_contenders.hpp"
#include "host/bench/check.hpp"

namespace glint::benchmarks {
namespace {

struct Result {
  std::string name;
  double median_ms = 0.0, p10_ms = 0.0, p90_ms = 0.0;
  std::size_t found = 0;  // in all cameras of all ticks
};

double quantile(std::vector<double>& values, double q) {
  const auto at = values.begin() + static_cast<std::ptrdiff_t>(q * static_cast<double>(values.size() - 1));
  std::nth_element(values.begin(), at, values.end());
  return *at;
}

/// Contenders take turns. Each runs on its own for a while before it is timed, because what the one before
/// left in the caches is no business of its own, and then long enough for its median to be that of a loop.
constexpr std::chrono::milliseconds kWarmUp{5}, kTimed{20};

std::vector<Result> race(const std::vector<Contender>& contenders, unsigned ticks, unsigned rounds) {
  using Clock = std::chrono::steady_clock;
  std::vector<Result> results;
  std::vector<std::vector<double>> times(contenders.size());
  for (const Contender& contender : contenders) {
    Result& result = results.emplace_back();
    result.name = contender.name;
    for (unsigned tick = 0; tick < ticks; ++tick) result.found += contender.run(tick);
  }
  for (unsigned round = 0; round < rounds; ++round) {
    for (std::size_t c = 0; c < contenders.size(); ++c) {
      unsigned tick = round;
      const auto one = [&] {
        const auto start = Clock::now();
        contenders[c].run(tick++ % ticks);
        return Clock::now() - start;
      };
      for (Clock::duration spent{}; spent < kWarmUp;) spent += one();
      unsigned timed = 0;
      for (Clock::duration spent{}; spent < kTimed || timed < ticks; ++timed) {
        const Clock::duration taken = one();
        spent += taken;
        times[c].push_back(std::chrono::duration<double, std::milli>(taken).count());
      }
    }
  }
  for (std::size_t c = 0; c < contenders.size(); ++c) {
    results[c].median_ms = quantile(times[c], 0.5);
    results[c].p10_ms = quantile(times[c], 0.1);
    results[c].p90_ms = quantile(times[c], 0.9);
  }
  return results;
}

double median_of(const std::vector<Result>& results, const std::string& part_of_name) {
  for (const Result& r : results) {
    if (r.name.find(part_of_name) != std::string::npos) return r.median_ms;
  }
  return 0.0;
}

void print_table(const SceneOptions& scene, const std::vector<Result>& results) {
  const double yardstick = median_of(results, "precomputed maps, 2 threads");
  std::printf("\n## %u cameras of %ux%u px, %u blobs each\n\n", scene.cameras, scene.width_px,
              scene.height_px, scene.blobs_per_camera);
  std::printf(
      "| per tick | median ms | p10 | p90 | precomputed maps 2T / this | blobs per tick "
      "|\n|---|---|---|---|---|---|\n");
  for (const Result& r : results) {
    std::printf("| %s | %.3f | %.3f | %.3f | %.1f | %.1f |\n", r.name.c_str(), r.median_ms, r.p10_ms,
                r.p90_ms, yardstick / r.median_ms, static_cast<double>(r.found) / scene.ticks);
  }
  const double native = median_of(results, "glint cpu (2 threads");
  std::printf(
      "\nNative on 2 threads: 1/%.1f of OpenCV lean on 2 threads, %.2f times reading the pixels once\n",
      median_of(results, "lean, 2 threads") / native, native / median_of(results, "once, 2 threads"));
  for (const Result& r : results) {
    if (r.name.find("Vulkan") == std::string::npos) continue;
    std::printf(
        "\n%s: %.3f of OpenCV with precomputed maps on 2 threads, %.2f of OpenCV lean on 1 thread, "
        "%.1f times native on 2 threads\n",
        r.name.c_str(), r.median_ms / yardstick, r.median_ms / median_of(results, "lean, 1 thread"),
        r.median_ms / native);
  }
  std::fflush(stdout);
}

nlohmann::json to_json(const SceneOptions& scene, const std::vector<Result>& results) {
  nlohmann::json json = {{"cameras", scene.cameras},
                         {"width_px", scene.width_px},
                         {"height_px", scene.height_px},
                         {"blobs_per_camera", scene.blobs_per_camera},
                         {"contenders", nlohmann::json::array()}};
  for (const Result& r : results) {
    json["contenders"].push_back({{"name", r.name},
                                  {"median_ms", r.median_ms},
                                  {"p10_ms", r.p10_ms},
                                  {"p90_ms", r.p90_ms},
                                  {"blobs_per_tick", static_cast<double>(r.found) / scene.ticks}});
  }
  return json;
}

int run(int argc, char** argv) {
  std::vector<unsigned> blobs = {0, 20, 200};
  unsigned rounds = 25;
  std::string json_path;
  SceneOptions options;
  CLI::App app{"glint's detectors beside OpenCV"};
  app.add_option("--scene", blobs, "blobs per camera; several make several tables")->capture_default_str();
  app.add_option("--iterations", rounds, "turns of each contender; each times as many sets as --ticks")
      ->capture_default_str()
      ->check(CLI::Range(1u, 100000u));
  app.add_option("--cameras", options.cameras)
      ->capture_default_str()
      ->check(CLI::Range(1u, gpu::kMaxCameras));
  app.add_option("--width", options.width_px)->capture_default_str()->check(CLI::Range(64u, 16384u));
  app.add_option("--height", options.height_px)->capture_default_str()->check(CLI::Range(64u, 16384u));
  app.add_option("--ticks", options.ticks, "different frame sets, shown in rotation")
      ->capture_default_str()
      ->check(CLI::Range(1u, 64u));
  app.add_option("--json", json_path, "also write the figures to this file");
  CLI11_PARSE(app, argc, argv);

  // Keep freed memory: otherwise OpenCV's images cost page faults on every tick.
  mallopt(M_MMAP_THRESHOLD, 1 << 30);
  mallopt(M_TRIM_THRESHOLD, 2147483647);

  nlohmann::json json = nlohmann::json::array();
  for (const unsigned count : blobs) {
    options.blobs_per_camera = count;
    Scene scene(options);
    const bench::Expected expected(scene);
    std::vector<Contender> contenders = memory_floor(scene);
    for (const NamedDetector& named : glint_detectors(scene)) {
      if (const std::string difference = expected.difference(*named.detector); !difference.empty()) {
        std::printf("FAIL: %s: %s\n", named.name.c_str(), difference.c_str());
        return 1;
      }
      contenders.push_back(as_contender(scene, named));
    }
    for (Contender& contender : opencv_contenders(scene)) contenders.push_back(std::move(contender));
    const std::vector<Result> results = race(contenders, options.ticks, rounds);
    print_table(options, results);
    json.push_back(to_json(options, results));
  }
  if (!json_path.empty()) {
    std::ofstream file(json_path);
    file << json.dump(2) << '\n';
    file.close();
    if (!file) throw std::runtime_error(json_path + ": cannot be written");
  }
  return 0;
}

}  // namespace
}  // namespace glint::benchmarks

int main(int argc, char** argv) {
  try {
    return glint::benchmarks::run(argc, argv);
  } catch (const std::exception& error) {
    std::fprintf(stderr, "peers: %s\n", error.what());
    return 1;
  }
}
