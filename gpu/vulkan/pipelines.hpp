// SPDX-License-Identifier: MIT
// The compute pipelines of the detector and the bindings that they share.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <span>

#include "gpu/vulkan/context.hpp"

namespace glint::gpu {

/// Binding numbers of shaders/*.comp.
enum Binding : std::uint32_t {
  kCameras,
  kFrames,
  kLimits,
  kTileFloors,
  kCounters,
  kTileList,
  kLinks,
  kSums,
  kParents,
  kHeads,
  kChain,
  kDivided,
  kPairs,
  kRoots,
  kBlobs,
  kBindingCount
};

constexpr vk::DescriptorType descriptor_type(std::uint32_t binding) {
  switch (binding) {
    case kCameras:
      return vk::DescriptorType::eUniformBuffer;
    case kFrames:
    case kLimits:
      return vk::DescriptorType::eUniformTexelBuffer;
    case kLinks:
    case kSums:
      return vk::DescriptorType::eStorageTexelBuffer;
    default:
      return vk::DescriptorType::eStorageBuffer;
  }
}

struct BlobPushConstants {
  std::uint32_t min_area_px, max_area_px, max_blobs;
};

struct Pipelines {
  /// most_fused_tiles: instead of what suits the device.
  explicit Pipelines(const VulkanDevice& gpu, std::optional<std::uint32_t> most_fused_tiles = {});

  std::uint32_t tiles_group = 0;         ///< invocations side by side in candidate_tiles
  std::uint32_t tiles_steps_across = 1;  ///< of their own width that they walk to the right
  std::uint32_t tiles_rows_down = 1;     ///< rows of tiles that they do so in
  std::uint32_t fused_group = 0;         ///< workgroup of the fused step
  std::uint32_t fused_tiles = 0;         ///< a camera with more candidate tiles goes through the split steps
  std::uint32_t most_turns = 0;          ///< of an invocation's unbounded loops, shaders/lib/turns.glsl

  vk::raii::DescriptorSetLayout set_layout;
  vk::raii::PipelineLayout layout;
  vk::raii::Pipeline candidate_tiles;
  std::array<vk::raii::Pipeline, 7> blobs;  ///< fused, then the six split steps

 private:
  vk::raii::Pipeline make(const VulkanDevice& gpu, std::span<const std::uint32_t> spirv, std::uint32_t group,
                          const char* name) const;
};

}  // namespace glint::gpu
