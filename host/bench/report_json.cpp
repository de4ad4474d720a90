// SPDX-License-Identifier: MIT
// The schema "glint-bench", version 1.
#include "host/bench/report_json.hpp"

#include <algorithm>
#include <fstream>
#include <sstream>

#include "host/bench/json_fields.hpp"

namespace glint::bench {

template <typename Archive>
void fields(Archive& a, Is<Machine> auto& machine) {
  a("processor", machine.processor);
  a("logical_cores", machine.logical_cores);
  a("architecture", machine.architecture);
  a("system", machine.system);
  a("kernel", machine.kernel);
  a("governor", machine.governor);
  a("compiler", machine.compiler);
}

template <typename Archive>
void fields(Archive& a, Is<Series> auto& series) {
  a("count", series.summary.count);
  a("p50_s", series.summary.p50);
  a("p90_s", series.summary.p90);
  a("p99_s", series.summary.p99);
  a("max_s", series.summary.max);
  a("median_low_s", series.summary.median_95.low);
  a("median_high_s", series.summary.median_95.high);
  a.samples("samples_s", series.samples);
}

template <typename Archive>
void fields(Archive& a, Is<StageSeries> auto& stage) {
  a("name", stage.name);
  a("time", stage.time);
}

template <typename Archive>
void fields(Archive& a, Is<SceneKey> auto& scene) {
  a("cameras", scene.cameras);
  a("width_px", scene.width_px);
  a("height_px", scene.height_px);
  a("blobs", scene.blobs);
  a("noise_grey", scene.noise_grey);
}

template <typename Archive>
void fields(Archive& a, Is<Paced> auto& paced) {
  a("rate_hz", paced.rate_hz);
  a("missed", paced.missed);
  a("latency", paced.latency);
}

template <typename Archive>
void fields(Archive& a, Is<Row> auto& row) {
  a("scene", row.scene);
  a("outcome", row.outcome);
  a("problem", row.problem);
  if (row.outcome != Outcome::Ok) return;  // no figures
  a("blobs_per_tick", row.blobs_per_tick);
  a("adopted_frame_memory", row.adopted_frame_memory);
  a("other_load_cores", row.other_load_cores);
  a("wall", row.wall);
  a("cpu", row.cpu);
  a("stages", row.stages);
  a("depth", row.depth);
  a("ticks_per_s", row.ticks_per_s);
  a("interval", row.interval);
  a("paced", row.paced);
}

template <typename Archive>
void fields(Archive& a, Is<Headline> auto& headline) {
  a("rate_hz", headline.rate_hz);
  a("outcome", headline.outcome);
  a("problem", headline.problem);
  if (headline.outcome != Outcome::Ok) return;
  a("cameras", headline.cameras);
  a("at_limit", headline.at_limit);
  a("p99_s", headline.p99_s);
}

template <typename Archive>
void fields(Archive& a, Is<gpu::MemoryHeap> auto& heap) {
  a("size_bytes", heap.size_bytes);
  a("device_local", heap.device_local);
  a("multi_instance", heap.multi_instance);
  a("host_visible", heap.host_visible);
}

template <typename Archive>
void fields(Archive& a, Is<VulkanProperties> auto& vulkan) {
  a("device_type", vulkan.device_type);
  a("vendor_id", vulkan.vendor_id);
  a("device_id", vulkan.device_id);
  a("api_version", vulkan.api_version);
  a("driver_id", vulkan.driver_id);
  a("driver_id_name", vulkan.driver_id_name);
  a("driver_name", vulkan.driver_name);
  a("driver_info", vulkan.driver_info);
  a("driver_version", vulkan.driver_version);
  a("conformance_version", vulkan.conformance_version);
  a("device_uuid", vulkan.device_uuid);
  a("driver_uuid", vulkan.driver_uuid);
  a("pci_bus", vulkan.pci_bus);
  a("subgroup_size", vulkan.subgroup_size);
  a("timestamp_period_ns", vulkan.timestamp_period_ns);
  a("imports_host_memory", vulkan.imports_host_memory);
  a("heaps", vulkan.heaps);
}

template <typename Archive>
void fields(Archive& a, Is<DeviceResult> auto& device) {
  a("name", device.name);
  a("software", device.software);
  a("vulkan", device.vulkan);
  a("headlines", device.headlines);
  a("rows", device.rows);
}

template <typename Archive>
void fields(Archive& a, Is<Conditions> auto& conditions) {
  a("warm_up_ticks", conditions.warm_up);
  a("ticks", conditions.ticks);
  a("max_time_s", conditions.max_time_s);
  a("rate_hz", conditions.rate_hz);
  a("depth", conditions.depth);
}

template <typename Archive>
void fields(Archive& a, Is<Results> auto& results) {
  a("glint_version", results.glint_version);
  a("glint_commit", results.glint_commit);
  a("shader_hash", results.shader_hash);
  a("started_utc", results.started_utc);
  a("machine", results.machine);
  a("conditions", results.conditions);
  a("headline_scene", results.headline_scene);
  a("notes", results.notes);
  a("devices", results.devices);
}

namespace {

constexpr std::size_t kLargestFile = std::size_t{512} << 20;

/// As nlohmann's dump(2), but lists of numbers stay in one line: thousands of samples are no thousands of
/// lines.
void print(const Json& value, std::string& out, std::size_t indent) {
  const auto simple = [](const Json& item) { return item.is_primitive(); };
  if (value.is_primitive() || value.empty() ||
      (value.is_array() && std::all_of(value.begin(), value.end(), simple))) {
    out += value.dump(-1, ' ', false, Json::error_handler_t::replace);
    return;
  }
  const std::string inside(indent + 2, ' ');
  out += value.is_array() ? "[\n" : "{\n";
  for (auto item = value.begin(); item != value.end(); ++item) {
    if (item != value.begin()) out += ",\n";
    out += inside;
    if (value.is_object()) out += Json(item.key()).dump() + ": ";
    print(*item, out, indent + 2);
  }
  out += "\n" + std::string(indent, ' ') + (value.is_array() ? "]" : "}");
}

Json comparison(const Results& results, const Baseline& baseline, const JsonWriter& write) {
  Json all = Json::array();
  for (const DeviceResult& device : results.devices) {
    for (const Row& row : device.rows) {
      const Row* before = matching_row(baseline.results, device.name, row.scene);
      for_each_series(row, [&](const std::string& name, const Series& series) {
        const std::optional<Change> change = change_of(name, series, before);
        if (!change) return;
        all.push_back({{"device", device.name},
                       {"scene", write(row.scene)},
                       {"series", name},
                       {"old_p50_s", change->old_p50},
                       {"ratio", change->ratio},
                       {"verdict", text(change->verdict)}});
      });
    }
  }
  return {{"file", baseline.path},
          {"glint_version", baseline.results.glint_version},
          {"glint_commit", baseline.results.glint_commit},
          {"shader_hash", baseline.results.shader_hash},
          {"changes", all}};
}

void check_schema(const Json& json, const std::string& name) {
  const auto schema = json.is_object() ? json.find("schema") : json.end();
  if (!json.is_object() || schema == json.end() || !schema->is_object() ||
      schema->value("name", Json()) != kSchemaName) {
    throw Error(name + ": is not a result of glint bench -o json: no \"schema\" with the name \"" +
                kSchemaName + "\"");
  }
  if (const Json version = schema->value("version", Json()); version != kSchemaVersion) {
    throw Error(name + ": has version " + version.dump() + " of the schema \"" + kSchemaName +
                "\"; this glint reads version " + std::to_string(kSchemaVersion));
  }
}

}  // namespace

std::string to_json(const Results& results, bool samples, const Baseline* baseline) {
  const JsonWriter write(samples);
  Json json = {{"schema", {{"name", kSchemaName}, {"version", kSchemaVersion}}}};
  json.update(write(results));
  if (baseline != nullptr) json["comparison"] = comparison(results, *baseline, write);
  std::string text;
  print(json, text, 0);
  return text + "\n";
}

Results parse_results(std::string_view text, const std::string& name) {
  Json json;
  try {
    json = Json::parse(text);
  } catch (const Json::exception& e) {
    throw Error(name + ": is damaged or no JSON: " + e.what());
  }
  check_schema(json, name);
  Results results;
  JsonReader(json, name + ": ").read(results);
  return results;
}

Results read_results(const std::filesystem::path& file) {
  std::error_code problem;
  const auto bytes = std::filesystem::file_size(file, problem);
  if (problem) throw Error(file.string() + ": cannot be read: " + problem.message());
  if (bytes > kLargestFile) throw Error(file.string() + ": is too large for a result of glint bench");
  std::ifstream stream(file, std::ios::binary);
  std::ostringstream text;
  text << stream.rdbuf();
  if (!stream) throw Error(file.string() + ": cannot be read");
  return parse_results(text.str(), file.string());
}

}  // namespace glint::bench
