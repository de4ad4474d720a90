// SPDX-License-Identifier: MIT
// The Vulkan detector, behind gpu/detector.hpp.
#pragma once

#include <memory>
#include <span>

#include "gpu/detector.hpp"

namespace glint::gpu {

/// Barriers between commands of one command buffer, numbered as they are recorded. Those towards the host and
/// between command buffers are not counted: synchronization validation does not look there.
inline constexpr int kBarriers = 6;

/// For tests that prove that each barrier is needed.
struct VulkanTestHooks {
  int omitted_barrier = -1;
};

/// device: as listed by list_devices(). Throws Error.
std::unique_ptr<Detector> make_vulkan_detector(const DeviceInfo& device,
                                               std::span<const CameraFormat> cameras,
                                               const DetectorOptions& options,
                                               const VulkanTestHooks& hooks = {});

}  // namespace glint::gpu
