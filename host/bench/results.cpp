// SPDX-License-Identifier: MIT
// Names for people.
#include "host/bench/results.hpp"

#include <cmath>
#include <cstdio>

#include "host/bench/scene.hpp"

namespace glint::bench {

namespace {

double whole_ns(double seconds) { return std::round(seconds * 1e9) / 1e9; }

}  // namespace

Series make_series(std::vector<double> samples_s) {
  for (double& sample : samples_s) sample = whole_ns(sample);
  Series series;
  Summary& s = series.summary = summarize(samples_s);
  for (double* value : {&s.p50, &s.p90, &s.p99, &s.max, &s.median_95.low, &s.median_95.high})
    *value = whole_ns(*value);
  series.samples = std::move(samples_s);
  return series;
}

void for_each_series(const Row& row, const std::function<void(const std::string&, const Series&)>& see) {
  see("wall", row.wall);
  see("cpu", row.cpu);
  see("interval", row.interval);
  see("paced", row.paced.latency);
  for (const StageSeries& stage : row.stages) see("stage " + stage.name, stage.time);
}

std::string display_name(const DeviceResult& device) {
  return device.name + (device.software ? " (software, no GPU)" : "");
}

std::string display_name(const SceneKey& scene) {
  std::string text = std::to_string(scene.cameras) + " x " + std::to_string(scene.width_px) + "x" +
                     std::to_string(scene.height_px) + ", " + std::to_string(scene.blobs) + " blobs";
  if (scene.noise_grey != SceneOptions{}.noise_grey) {
    char noise[40];
    std::snprintf(noise, sizeof noise, ", noise %g", scene.noise_grey);
    text += noise;
  }
  return text;
}

std::vector<std::string> problems(const Results& results) {
  const auto what = [](Outcome outcome) { return outcome == Outcome::Wrong ? "FAIL: " : "no result: "; };
  std::vector<std::string> lines;
  for (const DeviceResult& device : results.devices) {
    const std::size_t before = lines.size();
    for (const Row& row : device.rows) {
      if (row.outcome == Outcome::Ok || lines.size() > before) continue;
      lines.push_back(what(row.outcome) + display_name(device) + ": " + display_name(row.scene) + ": " +
                      row.problem);
    }
    for (const Headline& headline : device.headlines) {
      if (headline.outcome == Outcome::Ok || lines.size() > before) continue;
      lines.push_back(what(headline.outcome) + display_name(device) + ": most cameras: " + headline.problem);
    }
  }
  return lines;
}

}  // namespace glint::bench
