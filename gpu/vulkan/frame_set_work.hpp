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
  WorkLayout(std::span<const CameraFormat> cameras, const vk::PhysicalDeviceLimits& limits);

  std::vector<shaders::CameraParams> params;  ///< what does not change from set to set is filled in
  std::vector<vk::DeviceSize> frame_offset;   ///< bytes, in the detector's own frame buffer
  vk::DeviceSize frame_bytes = 0;
  std::uint32_t tiles = 0, components = 0, most_tiles_x = 0, most_tiles_y = 0;

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

  /// What the device spent on the set, after it is done: moving frames (if they are moved by the device),
  /// then dispatch by dispatch. Empty where the device has no time stamps.
  std::span<const StageTime> stages(bool many_tiles_ran);

  std::span<shaders::CameraParams> params() const;
  /// The counters of a camera after the commands are done.
  const shaders::CameraCounters& counters(std::uint32_t camera) const noexcept;
  std::span<const BlobRecord> records(std::uint32_t camera) const;  ///< max_blobs entries

  VulkanDevice::Buffer frames;   ///< the set's own frames (texels)
  VulkanDevice::Buffer staging;  ///< upload only: host side of `frames`
  /// What runs for every set, and what runs after it for cameras with many candidate tiles; without such
  /// cameras that costs little on a GPU, and some 20 us a dispatch on a CPU driver.
  struct Commands {
    vk::raii::CommandBuffer always{nullptr}, many_tiles{nullptr};
  };
  Commands own_frames, adopted_frames;
  /// After `always`: some camera needs `many_tiles`.
  bool needs_many_tiles() const noexcept;
  /// Upload only: commands that copy one camera's frame into `frames`. Throws vk::SystemError.
  vk::CommandBuffer record_upload(std::uint32_t camera, vk::Buffer from, vk::BufferCopy copy) const;
  vk::raii::Fence done;

 private:
  vk::raii::DescriptorSet make_set(const vk::raii::BufferView& frames_view);
  Commands record(vk::DescriptorSet set) const;
  void begin(const vk::raii::CommandBuffer& commands, vk::DescriptorSet set) const;
  void run(const vk::raii::CommandBuffer& commands, std::uint32_t step, std::size_t size_at) const;
  void end(const vk::raii::CommandBuffer& commands, int barrier_number) const;
  void stamp(const vk::raii::CommandBuffer& commands, std::uint32_t query) const;
  /// Seconds from one stamp to the next.
  double seconds(const std::uint64_t* stamps) const noexcept;
  bool read_stamps(std::uint32_t first, std::span<std::uint64_t> stamps) const noexcept;
  void barrier(const vk::raii::CommandBuffer& commands, int number, vk::PipelineStageFlags from,
               vk::AccessFlags written, vk::PipelineStageFlags to, vk::AccessFlags used) const;

  const VulkanDevice& gpu_;
  const Pipelines& pipelines_;
  const LimitBuffers& limits_;
  BlobPushConstants options_;
  std::uint32_t cameras_, most_tiles_x_, most_tiles_y_;
  int omitted_barrier_;
  VulkanDevice::Buffer params_, counters_, cleared_counters_, tile_list_, links_, sums_, parents_, heads_,
      chain_, divided_, pairs_, roots_, blobs_;
  VulkanDevice::Buffer header_;  // the counters, for the host
  std::optional<vk::raii::BufferView> own_view_, links_view_, sums_view_;
  vk::raii::DescriptorPool pool_;
  vk::raii::DescriptorSet own_set_{nullptr}, adopted_set_{nullptr};
  vk::raii::QueryPool queries_;
  std::vector<vk::raii::CommandBuffer> upload_commands_;  // one per camera
  std::vector<StageTime> stages_;
};

}  // namespace glint::gpu
