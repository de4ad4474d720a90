// SPDX-License-Identifier: MIT
// Figures chosen so that each can be told from all others.
#include "tests/unit/bench/sample_results.hpp"

namespace glint::bench::test {
namespace {

Row good_row(const SceneKey& scene, double median_s) {
  Row row;
  row.scene = scene;
  row.outcome = Outcome::Ok;
  row.blobs_per_tick = 4.0 * scene.blobs;
  row.adopted_frame_memory = true;
  row.other_load_cores = 0.03;
  row.wall = series_around(median_s, 0.1 * median_s);
  row.cpu = series_around(1.5 * median_s, 0.1 * median_s);
  row.stages = {{"find | tiles", series_around(0.6 * median_s, 0.01 * median_s)},
                {"blobs", series_around(0.2 * median_s, 0.01 * median_s, 7)}};
  row.depth = 2;
  row.ticks_per_s = 1.25 / median_s;
  row.interval = series_around(0.8 * median_s, 0.1 * median_s, 100);
  row.paced = {90.0, 3, series_around(1.1 * median_s, 0.2 * median_s)};
  return row;
}

VulkanProperties vulkan(const std::string& type, const std::string& driver) {
  VulkanProperties v;
  v.device_type = type;
  v.api_version = "1.3.230";
  v.driver_name = driver;
  v.driver_info = "Mesa 22.3.6";
  v.driver_id_name = "MesaLlvmpipe";
  v.conformance_version = "1.3.1.1";
  v.device_uuid = "6d657361-3232-2e33-2e36-000000000000";
  v.driver_uuid = "6c6c766d-7069-7065-5555-494400000000";
  v.pci_bus = "0000:01:00.0";
  v.vendor_id = 0x10005;
  v.device_id = 7;
  v.driver_version = 4294967295u;
  v.driver_id = 13;
  v.subgroup_size = 8;
  v.timestamp_period_ns = 0.5;
  v.imports_host_memory = true;
  v.heaps = {{17'179'869'184u, true, false, false}, {8'589'934'592u, false, false, true}};
  return v;
}

}  // namespace

Series series_around(double median_s, double spread_s, std::size_t count) {
  std::vector<double> samples;
  for (std::size_t i = 0; i < count;
       ++i) {  // 37 has no factor in common with the counts used: every value once
    const double at = static_cast<double>(i * 37 % count) / static_cast<double>(count - 1);
    samples.push_back(median_s + spread_s * (2.0 * at - 1.0));
  }
  return make_series(std::move(samples));
}

Results sample_results() {
  const SceneKey dark{4, 1280, 800, 0, 1.2}, noisy{4, 1280, 800, 20, 2.5};
  Results r;
  r.glint_version = "0.1.0";
  r.glint_commit = "abc1234";
  r.shader_hash = "00ff00ff00ff00ff";
  r.started_utc = "2026-01-02T03:04:05Z";
  r.machine = {"Some \"Fast\" CPU", "x86_64", "Debian GNU/Linux 12 (bookworm)", "Linux 6.1.0", "performance",
               "GCC 12.2.0",        8};
  r.conditions = {50, 500, 2, 2.0, 90.0};
  r.headline_scene = {0, 1280, 800, 20, 1.2};
  r.notes = {"left out: Old GPU: its driver offers Vulkan 1.0"};

  DeviceResult& software = r.devices.emplace_back();
  software.name = "llvmpipe";
  software.software = true;
  software.vulkan = vulkan("software", "llvmpipe");
  software.rows = {good_row(dark, 0.5e-3), good_row(noisy, 2e-3)};
  software.headlines = {{90.0, 21, false, 10.5e-3, Outcome::Ok, ""}, {250.0, 0, false, 0.0, Outcome::Ok, ""}};

  DeviceResult& wrong = r.devices.emplace_back();
  wrong.name = "Wrong GPU, fast";
  wrong.vulkan = vulkan("discrete", "broken");
  wrong.rows.resize(2);
  wrong.rows[0].scene = dark;
  wrong.rows[0].outcome = Outcome::Wrong;
  wrong.rows[0].problem = "tick 0, camera 1, blob 3: sum is 7 instead of 8";
  wrong.rows[1] = wrong.rows[0];
  wrong.rows[1].scene = noisy;
  wrong.headlines = {{90.0, 0, false, 0.0, Outcome::Wrong, "tick 0, camera 1: 3 blobs instead of 4"}};

  DeviceResult& cpu = r.devices.emplace_back();
  cpu.name = "cpu (8 threads, AVX2)";
  cpu.rows = {good_row(dark, 0.05e-3), {}};
  cpu.rows[1].scene = noisy;
  cpu.rows[1].problem = "it broke down: no memory";
  cpu.headlines = {{90.0, 32, true, 1.5e-3, Outcome::Ok, ""}};
  return r;
}

}  // namespace glint::bench::test
