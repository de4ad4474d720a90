// SPDX-License-Identifier: MIT
#include "benchmarks/identity/cost.hpp"

#include <time.h>

#include <algorithm>
#include <cstdio>
#include <vector>

#include "benchmarks/identity/product.hpp"
#include "host/base/error.hpp"
#include "host/pipeline/track_step.hpp"

namespace glint::identity {
namespace {

double thread_time_s() {
  timespec now{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
  return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
}

}  // namespace

Cost cost_of(std::uint32_t cameras, std::uint32_t markers, std::uint64_t ticks, unsigned most_looks) {
  SimOptions options;
  options.cameras = cameras;
  options.markers = markers;
  const Scene scene(options);
  MatchOptions match;
  match.marker_radius_m = options.marker_radius_m;
  match.exposure_s = options.exposure_s;
  match.most_looks = most_looks;
  TrackStep step(scene.calibration(), match, {}, {});
  const std::unique_ptr<TickInput> input = open_scene(scene, ticks);
  TickBlobs tick;
  std::vector<double> times;
  ReadStatus status = ReadStatus::Ok;
  for (std::uint64_t n = 0; (status = input->next(tick)) == ReadStatus::Ok; ++n) {
    const double begin_s = thread_time_s();
    step.take(tick);
    if (n >= ticks / 10) times.push_back(thread_time_s() - begin_s);
  }
  if (status == ReadStatus::Failed) throw Error(input->problem());
  Cost cost{cameras, markers, times.size(), 0.0, 0.0, 0.0};
  std::sort(times.begin(), times.end());
  if (times.empty()) return cost;
  cost.median_s = times[times.size() / 2];
  cost.p99_s = times[times.size() * 99 / 100];
  const MatchCounters& counters = step.match_counters();
  cost.looks = static_cast<double>(counters.resolved + counters.unresolved) / static_cast<double>(ticks);
  return cost;
}

std::string cost_head() {
  return "| cameras | markers | looks at pixels, per exposure | median (ms) | p99 (ms) "
         "|\n|---|---|---|---|---|\n";
}

std::string cost_row(const Cost& cost) {
  char text[120];
  std::snprintf(text, sizeof text, "| %u | %u | %.1f | %.2f | %.2f |\n", cost.cameras, cost.markers,
                cost.looks, 1e3 * cost.median_s, 1e3 * cost.p99_s);
  return text;
}

}  // namespace glint::identity
