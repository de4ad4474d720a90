// SPDX-License-Identifier: MIT
// Vulkan instance and device: set-up only, everything here may throw.
#include "gpu/vulkan/context.hpp"

#include <array>
#include <bit>
#include <cstdio>
#include <cstring>
#include <set>

namespace glint::gpu {
namespace {

constexpr const char* kValidationLayer = "VK_LAYER_KHRONOS_validation";

VKAPI_ATTR VkBool32 VKAPI_CALL on_message(VkDebugUtilsMessageSeverityFlagBitsEXT,
                                          VkDebugUtilsMessageTypeFlagsEXT,
                                          const VkDebugUtilsMessengerCallbackDataEXT* data, void* user) {
  (*static_cast<MessageSink*>(user))(data->pMessage);
  return VK_FALSE;
}

std::string uuid_text(const vk::ArrayWrapper1D<std::uint8_t, VK_UUID_SIZE>& uuid) {
  std::string text;
  for (std::size_t i = 0; i < uuid.size(); ++i) {
    char byte[4];
    std::snprintf(byte, sizeof byte, "%02x", static_cast<unsigned>(uuid[i]));
    if (i == 4 || i == 6 || i == 8 || i == 10) text += '-';
    text += byte;
  }
  return text;
}

const char* type_name(vk::PhysicalDeviceType type) {
  switch (type) {
    case vk::PhysicalDeviceType::eDiscreteGpu:
      return "discrete";
    case vk::PhysicalDeviceType::eIntegratedGpu:
      return "integrated";
    case vk::PhysicalDeviceType::eVirtualGpu:
      return "virtual";
    case vk::PhysicalDeviceType::eCpu:
      return "software";
    default:
      return "other";
  }
}

std::set<std::string> extension_names(const vk::raii::PhysicalDevice& device) {
  std::set<std::string> names;
  for (const vk::ExtensionProperties& e : device.enumerateDeviceExtensionProperties())
    names.insert(e.extensionName);
  return names;
}

std::optional<std::uint32_t> compute_family(const vk::raii::PhysicalDevice& device) {
  const auto families = device.getQueueFamilyProperties();
  for (std::uint32_t i = 0; i < families.size(); ++i) {
    if (families[i].queueFlags & vk::QueueFlagBits::eCompute) return i;
  }
  return std::nullopt;
}

void describe_driver(const vk::raii::PhysicalDevice& device, DeviceInfo& info) {
  const auto driver =
      device.getProperties2<vk::PhysicalDeviceProperties2, vk::PhysicalDeviceDriverProperties>()
          .get<vk::PhysicalDeviceDriverProperties>();
  info.driver_name = driver.driverName.data();
  info.driver_info = driver.driverInfo.data();
  info.driver_id = static_cast<std::uint32_t>(driver.driverID);
  info.driver_id_name = vk::to_string(driver.driverID);
  const vk::ConformanceVersion& passed = driver.conformanceVersion;
  info.conformance_version = std::to_string(passed.major) + "." + std::to_string(passed.minor) + "." +
                             std::to_string(passed.subminor) + "." + std::to_string(passed.patch);
}

std::string pci_bus(const vk::raii::PhysicalDevice& device) {
  const auto pci =
      device.getProperties2<vk::PhysicalDeviceProperties2, vk::PhysicalDevicePCIBusInfoPropertiesEXT>()
          .get<vk::PhysicalDevicePCIBusInfoPropertiesEXT>();
  char text[48];
  std::snprintf(text, sizeof text, "%04x:%02x:%02x.%x", pci.pciDomain, pci.pciBus, pci.pciDevice,
                pci.pciFunction);
  return text;
}

void describe_memory(const vk::raii::PhysicalDevice& device, DeviceInfo& info) {
  const vk::PhysicalDeviceMemoryProperties memory = device.getMemoryProperties();
  for (std::uint32_t h = 0; h < memory.memoryHeapCount; ++h) {
    const vk::MemoryHeap& heap = memory.memoryHeaps[h];
    MemoryHeap& described = info.heaps.emplace_back();
    described.size_bytes = heap.size;
    described.device_local = static_cast<bool>(heap.flags & vk::MemoryHeapFlagBits::eDeviceLocal);
    described.multi_instance = static_cast<bool>(heap.flags & vk::MemoryHeapFlagBits::eMultiInstance);
    for (std::uint32_t t = 0; t < memory.memoryTypeCount; ++t) {
      const vk::MemoryType& type = memory.memoryTypes[t];
      if (type.heapIndex == h && (type.propertyFlags & vk::MemoryPropertyFlagBits::eHostVisible))
        described.host_visible = true;
    }
    if (described.device_local) info.device_memory_bytes += heap.size;
  }
}

DeviceInfo describe(const vk::raii::PhysicalDevice& device, std::uint32_t number) {
  DeviceInfo info;
  info.index = number;
  const vk::PhysicalDeviceProperties basic = device.getProperties();
  info.name = basic.deviceName.data();
  info.type = type_name(basic.deviceType);
  info.software = basic.deviceType == vk::PhysicalDeviceType::eCpu;
  info.vendor_id = basic.vendorID;
  info.device_id = basic.deviceID;
  info.driver_version = basic.driverVersion;
  info.api_major = VK_API_VERSION_MAJOR(basic.apiVersion);
  info.api_minor = VK_API_VERSION_MINOR(basic.apiVersion);
  info.api_patch = VK_API_VERSION_PATCH(basic.apiVersion);
  info.max_workgroup_invocations = basic.limits.maxComputeWorkGroupInvocations;
  info.max_texel_buffer_elements = basic.limits.maxTexelBufferElements;
  info.timestamp_period_ns = static_cast<double>(basic.limits.timestampPeriod);
  if (basic.apiVersion < VK_API_VERSION_1_1) {
    info.why_not_usable = "its driver offers Vulkan " + std::to_string(info.api_major) + "." +
                          std::to_string(info.api_minor) + ", glint needs 1.1 or newer";
    return info;
  }
  const std::set<std::string> extensions = extension_names(device);
  const bool has_driver_properties =
      basic.apiVersion >= VK_API_VERSION_1_2 || extensions.contains(VK_KHR_DRIVER_PROPERTIES_EXTENSION_NAME);
  const auto properties = device.getProperties2<vk::PhysicalDeviceProperties2, vk::PhysicalDeviceIDProperties,
                                                vk::PhysicalDeviceSubgroupProperties>();
  info.uuid = uuid_text(properties.get<vk::PhysicalDeviceIDProperties>().deviceUUID);
  info.subgroup_size = properties.get<vk::PhysicalDeviceSubgroupProperties>().subgroupSize;
  info.driver_uuid = uuid_text(properties.get<vk::PhysicalDeviceIDProperties>().driverUUID);
  if (has_driver_properties) describe_driver(device, info);
  if (extensions.contains(VK_EXT_PCI_BUS_INFO_EXTENSION_NAME)) info.pci_bus = pci_bus(device);
  describe_memory(device, info);
  info.imports_host_memory = extensions.contains(VK_EXT_EXTERNAL_MEMORY_HOST_EXTENSION_NAME);
  info.usable = compute_family(device).has_value();
  if (!info.usable) info.why_not_usable = "it has no queue that computes";
  return info;
}

}  // namespace

VulkanInstance::VulkanInstance(const MessageSink& on_validation_message) {
  try {
    context_ = std::make_unique<vk::raii::Context>();
  } catch (const std::exception& e) {
    throw Error(std::string("no Vulkan loader (libvulkan.so.1): install libvulkan1 and a driver such as "
                            "mesa-vulkan-drivers, or use --device cpu (") +
                e.what() + ")");
  }
  const bool validate = static_cast<bool>(on_validation_message);
  try {
    const vk::ApplicationInfo application("glint", 1, "glint", 1, VK_API_VERSION_1_1);
    std::vector<const char*> layers, extensions;
    if (validate) {
      layers.push_back(kValidationLayer);
      extensions.push_back(VK_EXT_DEBUG_UTILS_EXTENSION_NAME);
    }
    const std::array checks{vk::ValidationFeatureEnableEXT::eGpuAssisted,
                            vk::ValidationFeatureEnableEXT::eGpuAssistedReserveBindingSlot,
                            vk::ValidationFeatureEnableEXT::eSynchronizationValidation};
    const vk::ValidationFeaturesEXT features(checks);
    const vk::InstanceCreateInfo create({}, &application, layers, extensions, validate ? &features : nullptr);
    instance_.emplace(*context_, create);
    if (validate) {
      sink_ = std::make_unique<MessageSink>(on_validation_message);
      using Severity = vk::DebugUtilsMessageSeverityFlagBitsEXT;
      using Type = vk::DebugUtilsMessageTypeFlagBitsEXT;
      messenger_.emplace(*instance_, vk::DebugUtilsMessengerCreateInfoEXT(
                                         {}, Severity::eError | Severity::eWarning,
                                         Type::eValidation | Type::ePerformance, &on_message, sink_.get()));
    }
  } catch (const vk::LayerNotPresentError&) {
    throw Error("the Vulkan validation layer is not installed: install vulkan-validationlayers");
  } catch (const vk::SystemError& e) {
    throw Error(std::string("Vulkan refuses to start: ") + e.what() +
                "; is a driver installed (mesa-vulkan-drivers)? --device cpu works without one");
  }
}

std::vector<DeviceInfo> VulkanInstance::devices() const {
  std::vector<DeviceInfo> all;
  std::uint32_t number = 0;
  for (const vk::raii::PhysicalDevice& device : vk::raii::PhysicalDevices(*instance_))
    all.push_back(describe(device, number++));
  return all;
}

vk::raii::PhysicalDevice VulkanInstance::physical_device(std::uint32_t device_index) const {
  vk::raii::PhysicalDevices all(*instance_);
  return std::move(all.at(device_index));
}

VulkanDevice::VulkanDevice(const VulkanInstance& instance, const DeviceInfo& device_info)
    : info(device_info),
      physical(instance.physical_device(device_info.index)),
      device(make_device()),
      queue(device, queue_family, 0),
      command_pool(device, {vk::CommandPoolCreateFlagBits::eResetCommandBuffer, queue_family}) {}

vk::raii::Device VulkanDevice::make_device() {
  queue_family = compute_family(physical).value();
  timestamp_bits = physical.getQueueFamilyProperties()[queue_family].timestampValidBits;
  limits = physical.getProperties().limits;
  const auto subgroup =
      physical.getProperties2<vk::PhysicalDeviceProperties2, vk::PhysicalDeviceSubgroupProperties>()
          .get<vk::PhysicalDeviceSubgroupProperties>();
  has_vote = (subgroup.supportedOperations & vk::SubgroupFeatureFlagBits::eVote) &&
             (subgroup.supportedStages & vk::ShaderStageFlagBits::eCompute);

  std::vector<const char*> extensions;
  if (info.imports_host_memory) {
    extensions.push_back(VK_EXT_EXTERNAL_MEMORY_HOST_EXTENSION_NAME);
    import_alignment = physical
                           .getProperties2<vk::PhysicalDeviceProperties2,
                                           vk::PhysicalDeviceExternalMemoryHostPropertiesEXT>()
                           .get<vk::PhysicalDeviceExternalMemoryHostPropertiesEXT>()
                           .minImportedHostPointerAlignment;
  }
  // GPU-assisted validation writes from every stage; ask for what the device has, nothing else needs
  // features.
  const vk::PhysicalDeviceFeatures available = physical.getFeatures();
  vk::PhysicalDeviceFeatures features;
  features.fragmentStoresAndAtomics = available.fragmentStoresAndAtomics;
  features.vertexPipelineStoresAndAtomics = available.vertexPipelineStoresAndAtomics;
  const float priority = 1.0f;
  const vk::DeviceQueueCreateInfo queue_info({}, queue_family, 1, &priority);
  try {
    return vk::raii::Device(physical, vk::DeviceCreateInfo({}, queue_info, {}, extensions, &features));
  } catch (const vk::SystemError& e) {
    throw Error("Vulkan device \"" + info.name + "\" cannot be opened: " + e.what() +
                "; choose another with --device (glint devices lists them)");
  }
}

std::optional<std::uint32_t> VulkanDevice::memory_type(std::uint32_t bits, vk::MemoryPropertyFlags required,
                                                       vk::MemoryPropertyFlags preferred) const {
  const vk::PhysicalDeviceMemoryProperties memory = physical.getMemoryProperties();
  std::optional<std::uint32_t> best;
  int best_score = -1;
  for (std::uint32_t i = 0; i < memory.memoryTypeCount; ++i) {
    const vk::MemoryPropertyFlags flags = memory.memoryTypes[i].propertyFlags;
    if (!(bits & (1u << i)) || (flags & required) != required) continue;
    const int score = std::popcount(static_cast<VkMemoryPropertyFlags>(flags & preferred));
    if (score > best_score) {
      best = i;
      best_score = score;
    }
  }
  return best;
}

VulkanDevice::Buffer VulkanDevice::make_buffer(vk::DeviceSize size, vk::BufferUsageFlags usage,
                                               vk::MemoryPropertyFlags required,
                                               vk::MemoryPropertyFlags preferred, const char* name) const {
  Buffer made;
  made.size = size;
  try {
    made.buffer = vk::raii::Buffer(device, vk::BufferCreateInfo({}, size, usage));
    const vk::MemoryRequirements needs = made.buffer.getMemoryRequirements();
    const auto type = memory_type(needs.memoryTypeBits, required, preferred);
    if (!type)
      throw Error("Vulkan device \"" + info.name + "\" has no memory of the kind needed for " + name);
    made.memory = vk::raii::DeviceMemory(device, vk::MemoryAllocateInfo(needs.size, *type));
    made.buffer.bindMemory(*made.memory, 0);
    if (required & vk::MemoryPropertyFlagBits::eHostVisible) {
      made.mapped = static_cast<std::byte*>(made.memory.mapMemory(0, VK_WHOLE_SIZE));
    }
  } catch (const vk::SystemError& e) {
    throw Error("Vulkan device \"" + info.name + "\": no " + std::to_string(size >> 10) + " KiB for " + name +
                ": " + e.what() + "; use fewer or smaller cameras, or another --device");
  }
  set_name(vk::ObjectType::eBuffer, reinterpret_cast<std::uint64_t>(static_cast<VkBuffer>(*made.buffer)),
           name);
  return made;
}

std::optional<VulkanDevice::Buffer> VulkanDevice::import_buffer(std::span<std::byte> memory,
                                                                vk::BufferUsageFlags usage,
                                                                const char* name) const {
  const auto address = reinterpret_cast<std::uintptr_t>(memory.data());
  if (import_alignment == 0 || address % import_alignment != 0 || memory.size() % import_alignment != 0)
    return std::nullopt;
  constexpr auto kKind = vk::ExternalMemoryHandleTypeFlagBits::eHostAllocationEXT;
  try {
    Buffer made;
    made.size = memory.size();
    const vk::ExternalMemoryBufferCreateInfo external(kKind);
    made.buffer = vk::raii::Buffer(device, vk::BufferCreateInfo({}, made.size, usage, {}, {}, {}, &external));
    const std::uint32_t pointer_bits =
        device.getMemoryHostPointerPropertiesEXT(kKind, memory.data()).memoryTypeBits;
    const auto type = memory_type(pointer_bits & made.buffer.getMemoryRequirements().memoryTypeBits,
                                  vk::MemoryPropertyFlagBits::eHostVisible |
                                      vk::MemoryPropertyFlagBits::eHostCoherent,  // nobody flushes
                                  vk::MemoryPropertyFlagBits::eHostCached);
    if (!type) return std::nullopt;
    const vk::ImportMemoryHostPointerInfoEXT import(kKind, memory.data());
    made.memory = vk::raii::DeviceMemory(device, vk::MemoryAllocateInfo(made.size, *type, &import));
    made.buffer.bindMemory(*made.memory, 0);
    set_name(vk::ObjectType::eBuffer, reinterpret_cast<std::uint64_t>(static_cast<VkBuffer>(*made.buffer)),
             name);
    return made;
  } catch (const vk::SystemError&) {
    return std::nullopt;  // the caller copies instead, and says so
  }
}

vk::raii::BufferView VulkanDevice::make_texel_view(const Buffer& buffer) const {
  return {device, vk::BufferViewCreateInfo({}, *buffer.buffer, vk::Format::eR32G32B32A32Uint, 0,
                                           buffer.size / 16 * 16)};
}

void VulkanDevice::set_name(vk::ObjectType type, std::uint64_t handle, const char* name) const {
  if (device.getDispatcher()->vkSetDebugUtilsObjectNameEXT == nullptr) return;
  device.setDebugUtilsObjectNameEXT(vk::DebugUtilsObjectNameInfoEXT(type, handle, name));
}

void VulkanDevice::run_once(const std::function<void(vk::raii::CommandBuffer&)>& record) const {
  vk::raii::CommandBuffers buffers(device, {*command_pool, vk::CommandBufferLevel::ePrimary, 1});
  vk::raii::CommandBuffer& commands = buffers.front();
  commands.begin({vk::CommandBufferUsageFlagBits::eOneTimeSubmit});
  record(commands);
  // What was copied or filled -> whatever runs next
  commands.pipelineBarrier(
      vk::PipelineStageFlagBits::eTransfer, vk::PipelineStageFlagBits::eComputeShader, {},
      vk::MemoryBarrier(vk::AccessFlagBits::eTransferWrite,
                        vk::AccessFlagBits::eShaderRead | vk::AccessFlagBits::eShaderWrite),
      {}, {});
  commands.end();
  const vk::CommandBuffer raw = *commands;
  queue.submit(vk::SubmitInfo({}, {}, raw));
  queue.waitIdle();
}

}  // namespace glint::gpu
