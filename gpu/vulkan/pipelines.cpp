// SPDX-License-Identifier: MIT
// Builds the pipelines from the embedded SPIR-V.
#include "gpu/vulkan/pipelines.hpp"

#include <algorithm>

#include "shaders/blobs_step0.spv.h"
#include "shaders/blobs_step1.spv.h"
#include "shaders/blobs_step2.spv.h"
#include "shaders/blobs_step3.spv.h"
#include "shaders/blobs_step4.spv.h"
#include "shaders/candidate_tiles.spv.h"
#include "shaders/candidate_tiles_vote.spv.h"

namespace glint::gpu {
namespace {

constexpr std::uint32_t kAllAcross = 4096;  // a whole row, however wide

vk::raii::DescriptorSetLayout make_set_layout(const VulkanDevice& gpu) {
  std::array<vk::DescriptorSetLayoutBinding, kBindingCount> bindings;
  for (std::uint32_t i = 0; i < kBindingCount; ++i) {
    const auto type = i == kCameras                  ? vk::DescriptorType::eUniformBuffer
                      : i == kFrames || i == kLimits ? vk::DescriptorType::eUniformTexelBuffer
                                                     : vk::DescriptorType::eStorageBuffer;
    bindings[i] = vk::DescriptorSetLayoutBinding(i, type, 1, vk::ShaderStageFlagBits::eCompute);
  }
  return {gpu.device, vk::DescriptorSetLayoutCreateInfo({}, bindings)};
}

vk::raii::PipelineLayout make_layout(const VulkanDevice& gpu, const vk::raii::DescriptorSetLayout& sets) {
  const vk::PushConstantRange push(vk::ShaderStageFlagBits::eCompute, 0, sizeof(BlobPushConstants));
  const vk::DescriptorSetLayout raw = *sets;
  return {gpu.device, vk::PipelineLayoutCreateInfo({}, raw, push)};
}

}  // namespace

// A CPU driver pays for every entry into a shader and for every wait of a lane: few invocations, long walks,
// and small workgroups for the fused step. A GPU hides latency with many threads: one tile each. (Measured on
// lavapipe; the GPU side is an estimate.)
Pipelines::Pipelines(const VulkanDevice& gpu)
    : tiles_group(gpu.info.software ? 8 : 64),
      tiles_steps_across(gpu.info.software && gpu.has_vote ? kAllAcross : 1),
      tiles_rows_down(gpu.info.software && gpu.has_vote ? 25 : 1),
      fused_group(std::min(64u, gpu.info.max_workgroup_invocations)),
      fused_tiles(fused_group * 16),
      set_layout(make_set_layout(gpu)),
      layout(make_layout(gpu, set_layout)),
      candidate_tiles(make(
          gpu, gpu.has_vote ? std::span<const std::uint32_t>(candidate_tiles_vote_spv) : candidate_tiles_spv,
          tiles_group, {tiles_steps_across, tiles_rows_down}, "candidate tiles")),
      blobs{make(gpu, blobs_step0_spv, fused_group, {fused_tiles, 0}, "blobs"),
            make(gpu, blobs_step1_spv, kSplitGroup, {fused_tiles, 0}, "tile components"),
            make(gpu, blobs_step2_spv, kSplitGroup, {fused_tiles, 0}, "join tiles"),
            make(gpu, blobs_step3_spv, kSplitGroup, {fused_tiles, 0}, "sum into roots"),
            make(gpu, blobs_step4_spv, kSplitGroup, {fused_tiles, 0}, "emit blobs")} {}

vk::raii::Pipeline Pipelines::make(const VulkanDevice& gpu, std::span<const std::uint32_t> spirv,
                                   std::uint32_t group, std::array<std::uint32_t, 2> values,
                                   const char* name) const {
  try {
    const vk::raii::ShaderModule module(gpu.device,
                                        vk::ShaderModuleCreateInfo({}, spirv.size_bytes(), spirv.data()));
    const std::array<std::uint32_t, 3> constants{group, values[0], values[1]};
    const std::array entries{vk::SpecializationMapEntry(0, 0, 4), vk::SpecializationMapEntry(1, 4, 4),
                             vk::SpecializationMapEntry(2, 8, 4)};
    const vk::SpecializationInfo specialization(static_cast<std::uint32_t>(entries.size()), entries.data(),
                                                sizeof constants, constants.data());
    const vk::PipelineShaderStageCreateInfo stage({}, vk::ShaderStageFlagBits::eCompute, *module, "main",
                                                  &specialization);
    vk::raii::Pipeline pipeline(gpu.device, nullptr, vk::ComputePipelineCreateInfo({}, stage, *layout));
    gpu.set_name(vk::ObjectType::ePipeline,
                 reinterpret_cast<std::uint64_t>(static_cast<VkPipeline>(*pipeline)), name);
    return pipeline;
  } catch (const vk::SystemError& e) {
    throw Error("Vulkan device \"" + gpu.info.name + "\" rejects the shader \"" + name + "\": " + e.what());
  }
}

}  // namespace glint::gpu
