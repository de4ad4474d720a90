// SPDX-License-Identifier: MIT
// How long extrinsics take: a waved wand before 8 and 32 simulated cameras, with our elimination order and
// with the settings that Ceres has by itself, one after the other in the same process.
//   benchmarks/calibrate [--cameras N]... [--ticks N] [--rounds N]
#include <algorithm>
#include <chrono>
#include <cstdio>
#include <vector>

#include <CLI/CLI.hpp>

#include "host/calibrate/extrinsics.hpp"
#include "host/sim/rig.hpp"
#include "host/sim/wand_sightings.hpp"

namespace {

struct Times {
  std::vector<double> all_s, adjustment_s;
};

double median(std::vector<double> values) {
  std::sort(values.begin(), values.end());
  return values[values.size() / 2];
}

glint::ExtrinsicsResult time_one(const glint::SampleSet& samples,
                                 const std::vector<glint::CameraCalibration>& lenses, bool schur,
                                 Times& times) {
  glint::ExtrinsicsOptions options;
  options.schur = schur;
  const auto begin = std::chrono::steady_clock::now();
  glint::ExtrinsicsResult result = glint::solve_extrinsics(samples, lenses, options);
  times.all_s.push_back(std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count());
  times.adjustment_s.push_back(result.adjustment.seconds);
  return result;
}

void run(std::uint32_t cameras, std::size_t ticks, int rounds) {
  glint::SimOptions options;
  options.cameras = cameras;
  const glint::Calibration rig = glint::sim_calibration(options);
  options.wand_m = {0.0, 0.13, 0.39};
  glint::SampleSet samples;
  samples.target = glint::wand_target(options.wand_m, options.marker_radius_m);
  for (const glint::CameraCalibration& c : rig.cameras)
    samples.cameras.push_back({c.name, c.width_px, c.height_px});
  for (const glint::WandSighting& s : glint::wand_sightings(rig, options, {ticks, 0.1, 0.05}))
    samples.sightings.push_back({s.tick, s.camera, s.point, s.pixel});
  std::vector<glint::CameraCalibration> lenses = rig.cameras;
  for (glint::CameraCalibration& lens : lenses) lens.world_from_camera = {};
  Times ours, plain;
  double fit_px = 0.0;
  for (int round = 0; round < rounds; ++round) {
    fit_px = time_one(samples, lenses, true, ours).quality.fit_rms_px;
    time_one(samples, lenses, false, plain);
  }
  std::printf("| %u | %zu | %zu | %.2f | %.3f | %.2f | %.3f | %.1f | %.3f |\n", cameras, ticks,
              samples.sightings.size(), median(ours.all_s), median(ours.adjustment_s), median(plain.all_s),
              median(plain.adjustment_s), median(plain.adjustment_s) / median(ours.adjustment_s), fit_px);
  std::fflush(stdout);
}

}  // namespace

int main(int argc, char** argv) {
  CLI::App app("Times of glint calibrate extrinsics");
  std::vector<std::uint32_t> cameras{4, 8, 32};
  std::size_t ticks = 2000;
  int rounds = 3;
  app.add_option("--cameras", cameras, "numbers of cameras")->check(CLI::Range(2, 32));
  app.add_option("--ticks", ticks, "wand samples")->capture_default_str();
  app.add_option("--rounds", rounds, "the medians are of so many")
      ->capture_default_str()
      ->check(CLI::PositiveNumber);
  CLI11_PARSE(app, argc, argv);
  std::printf(
      "| cameras | samples | sightings | all s | last adjustment s | Ceres' defaults: all s | last "
      "adjustment s | "
      "ratio | fit px rms |\n|---|---|---|---|---|---|---|---|---|\n");
  for (const std::uint32_t count : cameras) run(count, ticks, rounds);
  return 0;
}
