// SPDX-License-Identifier: MIT
// The Vulkan instance, the choice of a device, and its one compute queue.
#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include <vulkan/vulkan_raii.hpp>

#include "gpu/detector.hpp"

namespace glint::gpu {

using MessageSink = std::function<void(const std::string&)>;

/// Loader and instance. Throws Error if there is no Vulkan loader or it refuses.
class VulkanInstance {
 public:
  /// With a sink the Khronos validation layer is loaded and every message goes there. Throws Error if it is
  /// missing.
  explicit VulkanInstance(const MessageSink& on_validation_message = {});

  std::vector<DeviceInfo> devices() const;
  vk::raii::PhysicalDevice physical_device(std::uint32_t device_index) const;

 private:
  std::unique_ptr<MessageSink> sink_;  // at a fixed address: the messenger keeps a pointer
  std::unique_ptr<vk::raii::Context> context_;
  std::optional<vk::raii::Instance> instance_;
  std::optional<vk::raii::DebugUtilsMessengerEXT> messenger_;
};

/// A logical device with one queue that computes and copies.
struct VulkanDevice {
  VulkanDevice(const VulkanInstance& instance, const DeviceInfo& info);

  /// Buffer with its memory, mapped if it is host-visible.
  struct Buffer {
    vk::raii::DeviceMemory memory{nullptr};
    vk::raii::Buffer buffer{nullptr};
    vk::DeviceSize size = 0;
    std::byte* mapped = nullptr;
  };

  /// Throws Error when no memory type has all `required` flags; takes one with most of `preferred`.
  Buffer make_buffer(vk::DeviceSize size, vk::BufferUsageFlags usage, vk::MemoryPropertyFlags required,
                     vk::MemoryPropertyFlags preferred, const char* name) const;
  /// Host memory as a buffer, without a copy; nothing where the device or its driver declines.
  std::optional<Buffer> import_buffer(std::span<std::byte> memory, vk::BufferUsageFlags usage,
                                      const char* name) const;
  vk::raii::BufferView make_texel_view(const Buffer& buffer) const;  ///< 16-byte texels over the whole buffer
  void set_name(vk::ObjectType type, std::uint64_t handle, const char* name) const;
  /// Runs commands once and waits.
  void run_once(const std::function<void(vk::raii::CommandBuffer&)>& record) const;

  DeviceInfo info;
  vk::raii::PhysicalDevice physical;
  std::uint32_t queue_family = 0;
  std::uint32_t timestamp_bits = 0;
  bool has_vote = false;
  vk::PhysicalDeviceLimits limits;
  vk::DeviceSize import_alignment = 0;  ///< 0: cannot import
  vk::raii::Device device;
  vk::raii::Queue queue;
  vk::raii::CommandPool command_pool;

 private:
  vk::raii::Device make_device();
  std::optional<std::uint32_t> memory_type(std::uint32_t bits, vk::MemoryPropertyFlags required,
                                           vk::MemoryPropertyFlags preferred) const;
};

}  // namespace glint::gpu
