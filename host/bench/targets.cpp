// SPDX-License-Identifier: MIT
// From words after --device to detectors.
#include "host/bench/targets.hpp"

#include <algorithm>

#include "host/bench/check.hpp"

namespace glint::bench {
namespace {

std::vector<Target> all_targets(std::vector<std::string>& notes) {
  std::vector<Target> targets;
  std::string problem;
  const std::vector<gpu::DeviceInfo> devices = gpu::list_devices(&problem);
  if (devices.empty()) notes.push_back("no Vulkan device: " + problem);
  for (const gpu::DeviceInfo& device : devices) {
    if (device.usable) {
      targets.push_back({device});
    } else {
      notes.push_back("left out: " + device.name + ": " + device.why_not_usable);
    }
  }
  targets.push_back({});
  return targets;
}

bool same(const Target& a, const Target& b) {
  if (!a.vulkan || !b.vulkan) return a.vulkan.has_value() == b.vulkan.has_value();
  return a.vulkan->index == b.vulkan->index;
}

}  // namespace

std::vector<Target> choose_targets(std::span<const std::string> wanted, std::vector<std::string>& notes) {
  if (wanted.empty()) return all_targets(notes);
  std::vector<Target> targets;
  for (const std::string& name : wanted) {
    Target target;
    if (name != "cpu") target.vulkan = gpu::find_device(name);
    if (std::none_of(targets.begin(), targets.end(), [&](const Target& t) { return same(t, target); }))
      targets.push_back(std::move(target));
  }
  return targets;
}

DeviceResult describe(const Target& target) {
  DeviceResult result;
  result.name = "cpu";
  if (!target.vulkan) return result;
  const gpu::DeviceInfo& info = *target.vulkan;
  result.name = info.name;
  result.software = info.software;
  VulkanProperties& v = result.vulkan.emplace();
  v.device_type = info.type;
  v.api_version = std::to_string(info.api_major) + "." + std::to_string(info.api_minor) + "." +
                  std::to_string(info.api_patch);
  v.driver_name = info.driver_name;
  v.driver_info = info.driver_info;
  v.driver_id = info.driver_id;
  v.driver_id_name = info.driver_id_name;
  v.driver_version = info.driver_version;
  v.conformance_version = info.conformance_version;
  v.device_uuid = info.uuid;
  v.driver_uuid = info.driver_uuid;
  v.pci_bus = info.pci_bus;
  v.vendor_id = info.vendor_id;
  v.device_id = info.device_id;
  v.subgroup_size = info.subgroup_size;
  v.timestamp_period_ns = info.timestamp_period_ns;
  v.imports_host_memory = info.imports_host_memory;
  v.heaps = info.heaps;
  return result;
}

PreparedDetector make_detector(const Target& target, Scene& scene, unsigned cameras,
                               const TargetOptions& options) {
  gpu::DetectorOptions detector_options;
  detector_options.threads = options.threads;
  detector_options.depth = options.depth;
  std::vector<gpu::CameraFormat> formats = scene.formats();
  formats.resize(cameras);
  PreparedDetector made;
  made.detector = gpu::make_detector(target.vulkan ? std::to_string(target.vulkan->index) : "cpu", formats,
                                     detector_options);
  made.adopted_frame_memory = made.detector->adopt_frame_memory(scene.memory());
  set_limits(scene, *made.detector, cameras);
  return made;
}

}  // namespace glint::bench
