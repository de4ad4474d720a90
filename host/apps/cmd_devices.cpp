// SPDX-License-Identifier: MIT
// `glint devices`: what can run the detector.
#include <cstdio>

#include <nlohmann/json.hpp>

#include "gpu/detector.hpp"
#include "host/apps/commands.hpp"

namespace glint::apps {
namespace {

void print_json(const std::vector<gpu::DeviceInfo>& devices, const std::string& problem) {
  nlohmann::ordered_json all = nlohmann::ordered_json::array();
  for (const gpu::DeviceInfo& d : devices) {
    all.push_back({{"index", d.index},
                   {"name", d.name},
                   {"type", d.type},
                   {"software", d.software},
                   {"usable", d.usable},
                   {"why_not_usable", d.why_not_usable},
                   {"uuid", d.uuid},
                   {"vendor_id", d.vendor_id},
                   {"device_id", d.device_id},
                   {"driver_name", d.driver_name},
                   {"driver_info", d.driver_info},
                   {"vulkan", std::to_string(d.api_major) + "." + std::to_string(d.api_minor) + "." +
                                  std::to_string(d.api_patch)},
                   {"subgroup_size", d.subgroup_size},
                   {"max_workgroup_invocations", d.max_workgroup_invocations},
                   {"max_texel_buffer_elements", d.max_texel_buffer_elements},
                   {"device_memory_bytes", d.device_memory_bytes},
                   {"timestamp_period_ns", d.timestamp_period_ns},
                   {"imports_host_memory", d.imports_host_memory}});
  }
  std::printf("%s\n", nlohmann::ordered_json({{"devices", all}, {"problem", problem}}).dump(2).c_str());
}

void print_text(const std::vector<gpu::DeviceInfo>& devices, const std::string& problem) {
  for (const gpu::DeviceInfo& d : devices) {
    std::printf("%u    %s\n", d.index, d.name.c_str());
    std::printf("     %s%s, driver %s %s, Vulkan %u.%u.%u\n", d.type.c_str(), d.software ? " (no GPU)" : "",
                d.driver_name.c_str(), d.driver_info.c_str(), d.api_major, d.api_minor, d.api_patch);
    std::printf(
        "     %llu MiB memory, subgroup %u, workgroup up to %u, frames up to %llu MiB, %s, time stamps of %g "
        "ns\n",
        static_cast<unsigned long long>(d.device_memory_bytes >> 20), d.subgroup_size,
        d.max_workgroup_invocations, static_cast<unsigned long long>(d.max_texel_buffer_elements >> 16),
        d.imports_host_memory ? "reads host memory in place" : "copies frames", d.timestamp_period_ns);
    std::printf("     UUID %s\n", d.uuid.c_str());
    if (!d.usable) std::printf("     not usable: %s\n", d.why_not_usable.c_str());
  }
  if (devices.empty()) std::printf("no Vulkan device: %s\n", problem.c_str());
  std::printf("cpu  the processor itself, without Vulkan\n");
}

}  // namespace

void add_devices(CLI::App& app) {
  CLI::App* command = app.add_subcommand("devices", "List what can run the detector (--device)");
  const auto json = std::make_shared<bool>(false);
  command->add_flag("--json", *json, "as JSON");
  command->callback([json] {
    std::string problem;
    const std::vector<gpu::DeviceInfo> devices = gpu::list_devices(&problem);
    if (*json) {
      print_json(devices, problem);
    } else {
      print_text(devices, problem);
    }
  });
}

}  // namespace glint::apps
