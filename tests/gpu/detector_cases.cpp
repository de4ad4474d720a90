// SPDX-License-Identifier: MIT
// The matrix of devices and options.
#include "tests/gpu/detector_cases.hpp"

#include <ostream>

#include "gpu/cpu/detector_cpu.hpp"

namespace glint::gpu::testing {

std::unique_ptr<Detector> DetectorCase::make(std::span<const CameraFormat> cameras,
                                             DetectorOptions options) const {
  options.threads = threads;
  options.frame_path = frame_path;
  if (forced()) {
    for (const DeviceInfo& found : list_devices()) {
      if (found.uuid == device) return make_vulkan_detector(found, cameras, options, hooks);
    }
    throw Error("the device is gone: " + device);
  }
  if (on_gpu()) return make_detector(device, cameras, options);
  return make_cpu_detector(cameras, options, row_kernels()[kernels]);
}

void PrintTo(const DetectorCase& detector, std::ostream* out) { *out << detector.name; }

std::vector<DetectorCase> detector_cases() {
  std::vector<DetectorCase> cases;
  for (std::size_t k = 0; k < row_kernels().size(); ++k) {
    for (const unsigned threads : {1u, 2u, 5u}) {
      cases.push_back({"cpu_" + std::string(row_kernels()[k].name) + "_" + std::to_string(threads),
                       "",
                       k,
                       threads,
                       FramePath::Auto,
                       threads == 2,
                       threads == 2 ? Layout::Aligned : Layout::Unaligned,
                       {}});
    }
  }
  struct Path {
    const char* name;
    FramePath path;
    bool adopt;
    Layout layout;
  };
  for (const DeviceInfo& device : list_devices()) {
    if (!device.usable) continue;
    for (const Path& path : {Path{"auto_adopted", FramePath::Auto, true, Layout::Aligned},
                             Path{"auto", FramePath::Auto, false, Layout::Aligned},
                             Path{"auto_unaligned", FramePath::Auto, true, Layout::Unaligned},
                             Path{"import", FramePath::Import, true, Layout::Aligned},
                             Path{"copy", FramePath::Copy, true, Layout::Aligned},
                             Path{"upload", FramePath::Upload, false, Layout::Unaligned}}) {
      if (path.path == FramePath::Import && !device.imports_host_memory) continue;
      cases.push_back({"vulkan" + std::to_string(device.index) + "_" + path.name,
                       device.uuid,
                       0,
                       1,
                       path.path,
                       path.adopt,
                       path.layout,
                       {}});
    }
    // The ways to find blobs that the content or the device would choose otherwise.
    const auto force = [&](const char* way, const VulkanTestHooks& hooks) {
      cases.push_back({"vulkan" + std::to_string(device.index) + way, device.uuid, 0, 1, FramePath::Auto,
                       true, Layout::Aligned, hooks});
    };
    force("_all_split", {-1, 0, {}});
    force("_submitted_together", {-1, {}, true});
    force("_all_split_submitted_together", {-1, 0, true});
    force("_submitted_as_needed", {-1, {}, false});
  }
  return cases;
}

std::vector<DetectorCase> one_case_per_device() {
  std::vector<DetectorCase> cases;
  for (const DetectorCase& detector : detector_cases()) {
    const bool first_way = detector.on_gpu() ? detector.frame_path == FramePath::Auto && detector.adopt &&
                                                   detector.layout == Layout::Aligned && !detector.forced()
                                             : detector.kernels == 0;
    if (first_way) cases.push_back(detector);
  }
  return cases;
}

}  // namespace glint::gpu::testing
