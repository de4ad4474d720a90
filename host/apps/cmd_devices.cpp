// SPDX-License-Identifier: MIT
// `glint devices`: what can run the detector, the cameras, the sync boards.
#include <cstdio>

#include <nlohmann/json.hpp>

#include "gpu/detector.hpp"
#include "host/apps/camera_list.hpp"
#include "host/apps/commands.hpp"
#include "host/apps/device_list.hpp"
#include "host/apps/sync_board_list.hpp"

namespace glint::apps {
namespace {

nlohmann::ordered_json heaps_json(const std::vector<gpu::MemoryHeap>& heaps) {
  nlohmann::ordered_json all = nlohmann::ordered_json::array();
  for (const gpu::MemoryHeap& heap : heaps) {
    all.push_back({{"size_bytes", heap.size_bytes},
                   {"device_local", heap.device_local},
                   {"multi_instance", heap.multi_instance},
                   {"host_visible", heap.host_visible}});
  }
  return all;
}

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
                   {"driver_id", d.driver_id},
                   {"driver_id_name", d.driver_id_name},
                   {"driver_version", d.driver_version},
                   {"driver_uuid", d.driver_uuid},
                   {"conformance_version", d.conformance_version},
                   {"pci_bus", d.pci_bus},
                   {"vulkan", std::to_string(d.api_major) + "." + std::to_string(d.api_minor) + "." +
                                  std::to_string(d.api_patch)},
                   {"subgroup_size", d.subgroup_size},
                   {"max_workgroup_invocations", d.max_workgroup_invocations},
                   {"max_texel_buffer_elements", d.max_texel_buffer_elements},
                   {"device_memory_bytes", d.device_memory_bytes},
                   {"heaps", heaps_json(d.heaps)},
                   {"timestamp_period_ns", d.timestamp_period_ns},
                   {"imports_host_memory", d.imports_host_memory}});
  }
  nlohmann::ordered_json json({{"devices", all}, {"problem", problem}});
  add_camera_list(json);
  add_sync_boards(json);
  std::printf("%s\n", json.dump(2, ' ', false, nlohmann::ordered_json::error_handler_t::replace).c_str());
}

}  // namespace

void print_device_list() {
  std::string problem;
  const std::vector<gpu::DeviceInfo> devices = gpu::list_devices(&problem);
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

void add_devices(CLI::App& app) {
  CLI::App* command = app.add_subcommand(
      "devices", "List what can run the detector (--device), the cameras and the sync boards");
  const auto json = std::make_shared<bool>(false);
  command->add_flag("--json", *json, "as JSON");
  command->callback([json] {
    if (!*json) {
      print_device_list();
      print_camera_list();
      const std::string boards = sync_boards_text();
      if (!boards.empty()) std::printf("\nsync boards\n%s", boards.c_str());
      return;
    }
    std::string problem;
    const std::vector<gpu::DeviceInfo> devices = gpu::list_devices(&problem);
    print_json(devices, problem);
  });
}

}  // namespace glint::apps
