// SPDX-License-Identifier: MIT
// `glint bench`: how fast each device is here, and whether it is right.
#include <unistd.h>

#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <memory>
#include <optional>
#include <thread>

#include "host/apps/commands.hpp"
#include "host/apps/device_list.hpp"
#include "host/apps/progress_line.hpp"
#include "host/apps/version.hpp"
#include "host/base/error.hpp"
#include "host/bench/report_csv.hpp"
#include "host/bench/report_json.hpp"
#include "host/bench/report_markdown.hpp"
#include "host/bench/suite.hpp"
#include "host/files/text_file.hpp"

namespace glint::apps {
namespace {

// Cautious: computers with more cores have not been measured, and somebody else may want some. --threads asks
// for more.
constexpr unsigned kMostDefaultThreads = 8;

struct BenchArguments {
  std::vector<std::string> devices, sizes{"1280x800"};
  std::vector<unsigned> cameras{4}, blobs{0, 20, 200};
  std::vector<double> noise_grey{1.2}, headline_rates_hz{90.0, 250.0};
  bench::Conditions conditions;
  unsigned threads = std::clamp(std::thread::hardware_concurrency(), 1u, kMostDefaultThreads);
  std::string format = "md", output, compare;
  bool list_devices = false, no_headline = false, no_samples = false, force = false, quiet = false;
};

/// "1280x800"
void take_size(const std::string& text, bench::SceneKey& scene) {
  unsigned width = 0, height = 0;
  int used = 0;
  if (std::sscanf(text.c_str(), "%5ux%5u%n", &width, &height, &used) == 2 &&
      static_cast<std::size_t>(used) == text.size() && width >= 64 && height >= 64 &&
      std::uint64_t{width} * height <= gpu::kMaxPixels) {
    scene.width_px = width;
    scene.height_px = height;
    return;
  }
  throw UsageError("--sizes " + text +
                   ": must be WIDTHxHEIGHT in pixels, from 64x64 to 2^24 pixels, like 1280x800,1920x1200");
}

std::vector<bench::SceneKey> scenes_of(const BenchArguments& a) {
  std::vector<bench::SceneKey> scenes;
  for (const std::string& size : a.sizes) {
    for (const unsigned cameras : a.cameras) {
      for (const double noise : a.noise_grey) {
        for (const unsigned blobs : a.blobs) {
          bench::SceneKey& scene = scenes.emplace_back();
          take_size(size, scene);
          scene.cameras = cameras;
          scene.blobs = blobs;
          scene.noise_grey = noise;
        }
      }
    }
  }
  return scenes;
}

/// Minutes of measuring must not end at a file that cannot be written.
void check_output(const BenchArguments& a) {
  if (a.output.empty()) return;
  namespace fs = std::filesystem;
  const fs::path path(a.output), folder = path.has_parent_path() ? path.parent_path() : fs::path(".");
  if (fs::is_directory(path)) throw Error(a.output + ": is a folder; name a file in it");
  if (fs::exists(path) && !a.force)
    throw Error(a.output + ": the file exists already; choose another name or add --force to replace it");
  if (!fs::is_directory(folder)) throw Error(a.output + ": there is no such folder; make it first");
  if (::access(folder.c_str(), W_OK) != 0)
    throw Error(a.output + ": cannot be written; check the folder's permissions");
}

void write_report(const BenchArguments& a, const std::string& text) {
  if (!a.output.empty()) {
    write_text_file(a.output, text, a.force);
  } else if (std::fwrite(text.data(), 1, text.size(), stdout) != text.size() || std::fflush(stdout) != 0) {
    throw Error("standard output: cannot be written");
  }
}

void run(const BenchArguments& a) {
  if (a.list_devices) {
    print_device_list();
    return;
  }
  bench::SuiteOptions options;
  options.scenes = scenes_of(a);
  options.conditions = a.conditions;
  options.threads = a.threads;
  if (!a.no_headline) options.headline_rates_hz = a.headline_rates_hz;
  try {
    bench::check_scenes(options.scenes);
  } catch (const Error& e) {
    throw UsageError(e.what());
  }
  check_output(a);
  std::optional<bench::Baseline> baseline;
  if (!a.compare.empty()) baseline = bench::Baseline{a.compare, bench::read_results(a.compare)};
  std::vector<std::string> notes;
  options.targets = bench::choose_targets(a.devices, notes);

  bench::Results results;
  {
    ProgressLine progress(a.quiet);
    results = bench::run_suite(options, [&](const std::string& text) { progress.show(text); });
  }
  results.glint_version = kVersionNumber;
  results.glint_commit = kCommit;
  results.notes = notes;
  const bench::Baseline* before = baseline ? &*baseline : nullptr;
  write_report(a, a.format == "json"  ? bench::to_json(results, !a.no_samples, before)
                  : a.format == "csv" ? bench::to_csv(results, before)
                                      : bench::to_markdown(results, before));
  std::string problems;
  for (const std::string& problem : bench::problems(results))
    problems += (problems.empty() ? "" : "\n") + problem;
  if (!problems.empty()) throw Error(problems);
}

}  // namespace

void add_bench(CLI::App& app) {
  CLI::App* command =
      app.add_subcommand("bench", "Measure how fast devices are, after checking that they are right");
  const auto a = std::make_shared<BenchArguments>();
  bench::Conditions& c = a->conditions;
  command->add_option("-d,--device", a->devices,
                      "cpu, an index, a UUID or part of a name; may be repeated. Default: all, and the cpu");
  command->add_flag("--list-devices", a->list_devices, "list the devices and end");
  command->add_option("--cameras", a->cameras, "numbers of cameras")
      ->delimiter(',')
      ->capture_default_str()
      ->check(CLI::Range(1u, gpu::kMaxCameras));
  command->add_option("--sizes", a->sizes, "sizes of pictures")->delimiter(',')->capture_default_str();
  command->add_option("--blobs", a->blobs, "numbers of blobs per camera")
      ->delimiter(',')
      ->capture_default_str()
      ->check(CLI::Range(0u, 8192u));
  command->add_option("--noise", a->noise_grey, "standard deviations of the noise, grey levels")
      ->delimiter(',')
      ->capture_default_str()
      ->check(CLI::Range(0.0, 64.0));
  command->add_option("--threads", a->threads, "threads of the cpu")
      ->capture_default_str()
      ->check(CLI::Range(1u, 256u));
  command->add_option("--warmup", c.warm_up, "ticks that do not count, before each measurement")
      ->capture_default_str()
      ->check(CLI::Range(0u, 100000u));
  command->add_option("-n,--ticks", c.ticks, "ticks of each measurement")
      ->capture_default_str()
      ->check(CLI::Range(1u, 100000u));
  command->add_option("--max-time", c.max_time_s, "seconds after which each measurement ends")
      ->capture_default_str()
      ->check(CLI::Range(0.01, 3600.0));
  command->add_option("--depth", c.depth, "ticks in flight when measuring throughput")
      ->capture_default_str()
      ->check(CLI::Range(1u, 16u));
  command->add_option("--rate", c.rate_hz, "ticks per second when paced")
      ->capture_default_str()
      ->check(CLI::Range(0.1, 10000.0));
  command->add_option("--headline-rates", a->headline_rates_hz, "rates at which the most cameras are sought")
      ->delimiter(',')
      ->capture_default_str()
      ->check(CLI::Range(0.1, 10000.0));
  command->add_flag("--no-headline", a->no_headline, "do not seek the most cameras");
  command->add_option("-o,--format", a->format, "md, json (everything) or csv")
      ->capture_default_str()
      ->check(CLI::IsMember({"md", "json", "csv"}));
  command->add_option("--output", a->output, "a file instead of standard output");
  command->add_flag("--force", a->force, "replace an existing output file");
  command->add_flag("--no-samples", a->no_samples, "json: only quantiles, for a small file");
  command->add_option("--compare", a->compare, "an older result (-o json) to compare with")
      ->type_name("OLD.json");
  command->add_flag("--quiet", a->quiet, "no progress");
  command->callback([a] { run(*a); });
}

}  // namespace glint::apps
