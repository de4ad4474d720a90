// SPDX-License-Identifier: MIT
// Builds the pipelines from the embedded SPIR-V.
#include "gpu/vulkan/pipelines.hpp"

#include <algorithm>

#include "shaders/blobs_step0.spv.h"
#include "shaders/blobs_step1.spv.h"
#include "shaders/blobs_step2.spv.h"
#include "shaders/blobs_step3.spv.h"
#include "shaders/blobs_step4.spv.h"
#include "shaders/blobs_step5.spv.h"
#include "shaders/blobs_step6.spv.h"
#include "shaders/candidate_tiles.spv.h"
#include "shaders/candidate_tiles_vote.spv.h"
#include "shaders/interface/params.h"

namespace glint::gpu {
namespace {

constexpr std::uint32_t kAllAcross = 4096;  // a whole row, however wide

vk::raii::DescriptorSetLayout make_set_layout(const VulkanDevice& gpu) {
  std::array<vk::DescriptorSetLayoutBinding, kBindingCount> bindings;
  for (std::uint32_t i = 0; i < kBindingCount; ++i) {
    bindings[i] = vk::DescriptorSetLayoutBinding(i, descriptor_type(i), 1, vk::ShaderStageFlagBits::eCompute);
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
// and small workgroups for the fused step, though with enough of them to stay far from the driver's limit of
// loop turns. A GPU hides latency with many threads: one tile each. (Measured on lavapipe; the GPU side is an
// estimate.)
Pipelines::Pipelines(const VulkanDevice& gpu, std::optional<std::uint32_t> most_fused_tiles)
    : tiles_group(gpu.info.software ? 8 : 64),
      tiles_steps_across(gpu.info.software && gpu.has_vote ? kAllAcross : 1),
      tiles_rows_down(gpu.info.software && gpu.has_vote ? 25 : 1),
      fused_group(gpu.info.software ? 32 : std::min(256u, gpu.info.max_workgroup_invocations)),
      fused_tiles(most_fused_tiles.value_or(gpu.info.software ? 2048 : 4 * fused_group)),
      most_turns(gpu.info.software ? 60'000 : 0xffffffff),
      set_layout(make_set_layout(gpu)),
      layout(make_layout(gpu, set_layout)),
      candidate_tiles(make(
          gpu, gpu.has_vote ? std::span<const std::uint32_t>(candidate_tiles_vote_spv) : candidate_tiles_spv,
          tiles_group, "candidate tiles")),
      blobs{make(gpu, blobs_step0_spv, fused_group, "blobs"),
            make(gpu, blobs_step1_spv, shaders::kSplitGroup, "sum tiles"),
            make(gpu, blobs_step2_spv, shaders::kSplitGroup, "divide tiles"),
            make(gpu, blobs_step3_spv, shaders::kSplitGroup, "join tiles"),
            make(gpu, blobs_step4_spv, shaders::kSplitGroup, "join pairs"),
            make(gpu, blobs_step5_spv, shaders::kSplitGroup, "gather components"),
            make(gpu, blobs_step6_spv, shaders::kSplitGroup, "emit blobs")} {}

vk::raii::Pipeline Pipelines::make(const VulkanDevice& gpu, std::span<const std::uint32_t> spirv,
                                   std::uint32_t group, const char* name) const {
  try {
    const vk::raii::ShaderModule module(gpu.device,
                                        vk::ShaderModuleCreateInfo({}, spirv.size_bytes(), spirv.data()));
    const std::array constants{group, tiles_steps_across, tiles_rows_down, fused_tiles, most_turns};
    std::array<vk::SpecializationMapEntry, constants.size()> entries;
    for (std::uint32_t i = 0; i < entries.size(); ++i) entries[i] = vk::SpecializationMapEntry(i, 4 * i, 4);
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
