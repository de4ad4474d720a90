// SPDX-License-Identifier: MIT
// The Vulkan detector, behind gpu/detector.hpp.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <span>

#include "gpu/detector.hpp"

namespace glint::gpu {

/// Barriers between commands of one command buffer, numbered as they are recorded. Those towards the host and
/// between command buffers are not counted: synchronization validation does not look there.
inline constexpr int kBarriers = 8;

/// For tests: proof that each barrier is needed, and the ways that other devices take.
struct VulkanTestHooks {
  int omitted_barrier = -1;
  std::optional<std::uint32_t>
      fused_tiles;  ///< up to so many candidate tiles a camera goes through the fused step
  std::optional<bool> submit_together;  ///< all commands at once, whether needed or not
};

/// device: as listed by list_devices(). Throws Error.
std::unique_ptr<Detector> make_vulkan_detector(const DeviceInfo& device,
                                               std::span<const CameraFormat> cameras,
                                               const DetectorOptions& options,
                                               const VulkanTestHooks& hooks = {});

}  // namespace glint::gpu
