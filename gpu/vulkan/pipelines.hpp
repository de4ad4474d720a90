// SPDX-License-Identifier: MIT
// The compute pipelines of the detector and the bindings that they share.
#pragma once

#include <array>
#include <cstdint>

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
  kTileMap,
  kParents,
  kLinks,
  kSums,
  kBlobs,
  kHeader,
  kRoots,
  kBindingCount
};

struct BlobPushConstants {
  std::uint32_t min_area_px, max_area_px, max_blobs, slots;
};

inline constexpr std::uint32_t kSumFields = 18;   ///< of shaders/lib/component_sums.glsl
inline constexpr std::uint32_t kSplitGroup = 64;  ///< workgroup of the split steps in shaders/blobs.comp

struct Pipelines {
  explicit Pipelines(const VulkanDevice& gpu);

  std::uint32_t tiles_group = 0;         ///< invocations side by side in candidate_tiles
  std::uint32_t tiles_steps_across = 1;  ///< of their own width that they walk to the right
  std::uint32_t tiles_rows_down = 1;     ///< rows of tiles that they do so in
  std::uint32_t fused_group = 0;         ///< workgroup of the fused step
  std::uint32_t fused_tiles = 0;         ///< a camera with more candidate tiles goes through the split steps

  vk::raii::DescriptorSetLayout set_layout;
  vk::raii::PipelineLayout layout;
  vk::raii::Pipeline candidate_tiles;
  std::array<vk::raii::Pipeline, 5> blobs;  ///< fused, then the four split steps

 private:
  vk::raii::Pipeline make(const VulkanDevice& gpu, std::span<const std::uint32_t> spirv, std::uint32_t group,
                          std::array<std::uint32_t, 2> constants, const char* name) const;
};

}  // namespace glint::gpu
