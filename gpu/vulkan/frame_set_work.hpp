// SPDX-License-Identifier: MIT
// Everything that one frame set in flight owns on the GPU: buffers, descriptor sets, recorded commands.
#pragma once

#include <array>
#include <optional>
#include <span>
#include <vector>

#include "gpu/vulkan/pipelines.hpp"
#include "shaders/interface/params.h"

namespace glint::gpu {

/// Sizes and offsets of all cameras in the shared buffers.
struct WorkLayout {
  WorkLayout(std::span<const CameraFormat> cameras, std::uint32_t largest_buffer_bytes);

  std::vector<shaders::CameraParams> params;  ///< what does not change from set to set is filled in
  std::vector<vk::DeviceSize> frame_offset;   ///< bytes, in the detector's own frame buffer
  vk::DeviceSize frame_bytes = 0, limit_bytes = 0;
  std::uint32_t tiles = 0, slots = 0, most_tiles_x = 0, most_tiles_y = 0;

  std::uint32_t stride_bytes(std::size_t camera) const {
    return params[camera].tiles_x * shaders::kTileWidth;
  }
};

/// Buffers that all sets share: written before the loop.
struct LimitBuffers {
  VulkanDevice::Buffer limits, tile_floors;
  std::optional<vk::raii::BufferView> limits_view;
};

class FrameSetWork {
 public:
  /// `upload`: the set's own frame buffer is device memory and filled by copies; else the host writes it
  /// directly.
  FrameSetWork(const VulkanDevice& gpu, const Pipelines& pipelines, const WorkLayout& layout,
               const LimitBuffers& limits, const BlobPushConstants& options, bool upload,
               int omitted_barrier);

  /// Records a second set of commands that reads frames from adopted memory. Throws vk::SystemError.
  void use_adopted_frames(const vk::raii::BufferView& frames);

  /// Dispatches in the order of their time stamps; the last four belong to `large`.
  static constexpr std::array<const char*, 6> kStages{"candidate tiles", "blobs",     "tile components",
                                                      "join tiles",      "sum roots", "emit blobs"};
  /// Seconds of the dispatches that ran, after the set is done; empty where the device has no time stamps.
  std::span<const double> stage_seconds(bool large_ran);

  /// Some camera had more candidate tiles than the fused step takes: record and run the `large` commands.
  bool needs_large() const noexcept { return largest_tiles() > pipelines_.fused_tiles; }

  std::span<shaders::CameraParams> params() const;
  /// The counters of a camera after the commands are done.
  const shaders::CameraCounters& counters(std::uint32_t camera) const noexcept;
  std::span<const BlobRecord> records(std::uint32_t camera) const;  ///< max_blobs entries

  VulkanDevice::Buffer frames;   ///< the set's own frames (texels)
  VulkanDevice::Buffer staging;  ///< upload only: host side of `frames`
  /// What runs for every set, and what runs after it when needs_large(): that is recorded for the number of
  /// tiles.
  struct Commands {
    vk::raii::CommandBuffer always{nullptr}, large{nullptr};
    vk::DescriptorSet set;
  };
  Commands own_frames, adopted_frames;
  void record_large(const Commands& commands) const;
  std::vector<vk::raii::CommandBuffer> upload_commands;  ///< one per camera
  vk::raii::Fence done;

 private:
  vk::raii::DescriptorSet make_set(const vk::raii::BufferView& frames_view);
  Commands record(const vk::raii::DescriptorSet& set) const;
  void begin(const vk::raii::CommandBuffer& commands, vk::DescriptorSet set) const;
  std::uint32_t largest_tiles() const noexcept;
  void stamp(const vk::raii::CommandBuffer& commands, std::uint32_t query) const;
  void barrier(const vk::raii::CommandBuffer& commands, int number, vk::PipelineStageFlags from,
               vk::AccessFlags written, vk::PipelineStageFlags to, vk::AccessFlags used) const;

  const VulkanDevice& gpu_;
  const Pipelines& pipelines_;
  const LimitBuffers& limits_;
  BlobPushConstants options_;
  std::uint32_t cameras_, most_tiles_x_, most_tiles_y_;
  int omitted_barrier_;
  VulkanDevice::Buffer params_, counters_, tile_list_, tile_map_, parents_, links_, sums_, roots_, blobs_,
      header_, large_header_;
  std::optional<vk::raii::BufferView> own_view_;
  vk::raii::DescriptorPool pool_;
  vk::raii::DescriptorSet own_set_{nullptr}, adopted_set_{nullptr};
  vk::raii::QueryPool queries_;
  std::array<double, kStages.size()> stage_seconds_{};
};

}  // namespace glint::gpu
