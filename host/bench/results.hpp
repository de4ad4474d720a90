// SPDX-License-Identifier: MIT
// What a run of `glint bench` found out. Times in seconds.
#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "gpu/detector.hpp"
#include "host/bench/statistics.hpp"

namespace glint::bench {

/// The computer that it ran on; an empty text is not known.
struct Machine {
  std::string processor, architecture, system, kernel, governor, compiler;
  unsigned logical_cores = 0;
};

struct Series {
  Summary summary;
  std::vector<double> samples;  ///< in the order taken; may be left out of a file
};

/// Summarizes samples, which it keeps, all rounded to whole nanoseconds.
Series make_series(std::vector<double> samples_s);

struct StageSeries {
  std::string name;  ///< as the detector calls it
  Series time;       ///< only of ticks in which it ran
};

struct SceneKey {
  unsigned cameras = 0, width_px = 0, height_px = 0, blobs = 0;
  double noise_grey = 0.0;
  bool operator==(const SceneKey&) const = default;
};

enum class Outcome : std::uint8_t {
  Ok,
  Wrong,   ///< differs from the reference: no figures
  Failed,  ///< could not be set up, or broke down: no figures
};

/// Paced as cameras are.
struct Paced {
  double rate_hz = 0.0;
  std::uint64_t missed = 0;  ///< results later than one period after their tick was due
  Series latency;            ///< submit to result
};

/// One device on one scene. Without Outcome::Ok there is `problem` and no figure.
struct Row {
  SceneKey scene;
  Outcome outcome = Outcome::Failed;
  std::string problem;
  double blobs_per_tick = 0.0;        ///< in all cameras together
  bool adopted_frame_memory = false;  ///< the detector took the frames' memory and need not copy it by CPU
  /// How many cores other programs kept busy meanwhile, on average; nothing where that is not known.
  std::optional<double> other_load_cores;
  Series wall;                      ///< one tick at a time: submit to result
  Series cpu;                       ///< of the whole process, per tick of `wall`
  std::vector<StageSeries> stages;  ///< of the ticks of `wall`
  unsigned depth = 0;               ///< ticks in flight for `interval`
  double ticks_per_s = 0.0;
  Series interval;  ///< between results, as fast as it goes
  Paced paced;
};

/// Calls `see` with each series of a row and its name: "wall", "cpu", "interval", "paced" or "stage NAME".
void for_each_series(const Row& row, const std::function<void(const std::string&, const Series&)>& see);

/// The most cameras of one size that a device keeps up with.
struct Headline {
  double rate_hz = 0.0;
  unsigned cameras = 0;   ///< 0: not even one
  bool at_limit = false;  ///< as many as glint supports: there may be room for more
  double p99_s = 0.0;     ///< with so many cameras
  Outcome outcome = Outcome::Failed;
  std::string problem;  ///< with Ok: why more cameras cannot be set up, where that is the limit and not time
};

/// What Vulkan says about a device, under Vulkan's names.
struct VulkanProperties {
  std::string device_type, api_version, driver_name, driver_info, driver_id_name, conformance_version;
  std::string device_uuid, driver_uuid, pci_bus;
  std::uint32_t vendor_id = 0, device_id = 0, driver_version = 0, driver_id = 0, subgroup_size = 0;
  double timestamp_period_ns = 0.0;
  bool imports_host_memory = false;
  std::vector<gpu::MemoryHeap> heaps;
};

struct DeviceResult {
  std::string name;                        ///< "llvmpipe (LLVM 15.0.6, 256 bits)", "cpu (2 threads, AVX2)"
  bool software = false;                   ///< a Vulkan device without a GPU
  std::optional<VulkanProperties> vulkan;  ///< nothing: the native CPU detector
  std::vector<Row> rows;
  std::vector<Headline> headlines;
};

/// How it was measured.
struct Conditions {
  unsigned warm_up = 50, ticks = 500, depth = 2;
  double max_time_s = 2.0, rate_hz = 90.0;
};

struct Results {
  std::string glint_version, glint_commit, shader_hash, started_utc;
  Machine machine;
  Conditions conditions;
  SceneKey headline_scene;  ///< cameras is 0: that is what is asked
  std::vector<std::string> notes;
  std::vector<DeviceResult> devices;
};

/// "llvmpipe (LLVM 15.0.6, 256 bits) (software, no GPU)": never without the mark.
std::string display_name(const DeviceResult& device);
/// "4 x 1280x800, 20 blobs"; the noise only where it is not the usual one.
std::string display_name(const SceneKey& scene);
/// The first row or headline of each device that is not Ok, one line each; empty if all is well.
std::vector<std::string> problems(const Results& results);

}  // namespace glint::bench
