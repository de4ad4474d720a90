// SPDX-License-Identifier: MIT
// Memory and commands of one frame set in flight.
#include "gpu/vulkan/frame_set_work.hpp"

#include <algorithm>
#include <cstddef>
#include <cstring>

namespace glint::gpu {
namespace {

using Usage = vk::BufferUsageFlagBits;
using Memory = vk::MemoryPropertyFlagBits;
using Stage = vk::PipelineStageFlagBits;
using Access = vk::AccessFlagBits;

constexpr vk::MemoryPropertyFlags kHost = Memory::eHostVisible | Memory::eHostCoherent;
constexpr std::array kStages{"candidate tiles", "blobs, fused", "sum tiles", "divide tiles",
                             "join tiles",      "join pairs",   "gather",    "emit blobs"};
// Time stamps around the first two dispatches and between them; the same for the other six; two for each
// upload.
constexpr std::uint32_t kManyQueries = 3, kUploadQueries = kManyQueries + 7;

constexpr vk::AccessFlags kReadWrite = Access::eShaderRead | Access::eShaderWrite;
constexpr std::uint32_t kTexelBytes = 16, kLinkBytes = 16, kSumBytes = 32;  // shaders/lib/component.glsl
constexpr int kNeeded = -2;  // barriers that are not among the numbered ones: kBarriers says why

std::uint32_t groups(std::uint32_t items, std::uint32_t each) { return (items + each - 1) / each; }

vk::raii::DescriptorPool make_pool(const VulkanDevice& gpu) {
  const std::array sizes{vk::DescriptorPoolSize(vk::DescriptorType::eUniformBuffer, 2),
                         vk::DescriptorPoolSize(vk::DescriptorType::eUniformTexelBuffer, 4),
                         vk::DescriptorPoolSize(vk::DescriptorType::eStorageTexelBuffer, 4),
                         vk::DescriptorPoolSize(vk::DescriptorType::eStorageBuffer, 2 * (kBindingCount - 5))};
  return {gpu.device,
          vk::DescriptorPoolCreateInfo(vk::DescriptorPoolCreateFlagBits::eFreeDescriptorSet, 2, sizes)};
}

}  // namespace

WorkLayout::WorkLayout(std::span<const CameraFormat> cameras, const vk::PhysicalDeviceLimits& limits) {
  std::uint64_t all_tiles = 0;
  for (const CameraFormat& camera : cameras) {
    all_tiles += std::uint64_t{groups(camera.width_px, shaders::kTileWidth)} *
                 (groups(camera.height_px, shaders::kTileHeight));
  }
  // A tile holds at most 32 components. On a device whose largest buffer is too small for that, images with
  // many components in every tile overflow before they have more blobs than there is room for.
  const std::uint64_t fit =
      std::uint64_t{limits.maxTexelBufferElements} * kTexelBytes / (all_tiles * kSumBytes);
  const auto extra_per_tile = static_cast<std::uint32_t>(std::clamp<std::uint64_t>(fit, 2, 33) - 1);
  for (const CameraFormat& camera : cameras) {
    shaders::CameraParams p{};
    p.width_px = camera.width_px;
    p.height_px = camera.height_px;
    p.tiles_x = groups(camera.width_px, shaders::kTileWidth);
    p.tiles_y = groups(camera.height_px, shaders::kTileHeight);
    const std::uint32_t camera_tiles = p.tiles_x * p.tiles_y;
    p.tile_base = tiles;
    p.component_base = components;
    p.extra_components = extra_per_tile * camera_tiles;
    p.fx_px = static_cast<float>(camera.lens.fx_px);
    p.fy_px = static_cast<float>(camera.lens.fy_px);
    p.cx_px = static_cast<float>(camera.lens.cx_px);
    p.cy_px = static_cast<float>(camera.lens.cy_px);
    p.k1 = static_cast<float>(camera.lens.k1_k2_p1_p2_k3[0]);
    p.k2 = static_cast<float>(camera.lens.k1_k2_p1_p2_k3[1]);
    p.p1 = static_cast<float>(camera.lens.k1_k2_p1_p2_k3[2]);
    p.p2 = static_cast<float>(camera.lens.k1_k2_p1_p2_k3[3]);
    p.k3 = static_cast<float>(camera.lens.k1_k2_p1_p2_k3[4]);
    params.push_back(p);
    const std::uint32_t rows = p.tiles_y * shaders::kTileHeight;
    frame_offset.push_back(frame_bytes);
    frame_bytes += vk::DeviceSize{p.tiles_x} * shaders::kTileWidth * rows;
    tiles += camera_tiles;
    components += camera_tiles + p.extra_components;
    most_tiles_x = std::max(most_tiles_x, p.tiles_x);
    most_tiles_y = std::max(most_tiles_y, p.tiles_y);
  }
}

FrameSetWork::FrameSetWork(const VulkanDevice& gpu, const Pipelines& pipelines, const WorkLayout& layout,
                           const LimitBuffers& limits, const BlobPushConstants& options, bool upload,
                           int omitted_barrier)
    : done(gpu.device, vk::FenceCreateInfo()),
      gpu_(gpu),
      pipelines_(pipelines),
      limits_(limits),
      options_(options),
      cameras_(static_cast<std::uint32_t>(layout.params.size())),
      most_tiles_x_(layout.most_tiles_x),
      most_tiles_y_(layout.most_tiles_y),
      omitted_barrier_(omitted_barrier),
      pool_(make_pool(gpu)),
      queries_(gpu.device,
               vk::QueryPoolCreateInfo({}, vk::QueryType::eTimestamp, kUploadQueries + 2 * cameras_)) {
  const auto local = [&](vk::DeviceSize size, vk::BufferUsageFlags usage, const char* name) {
    return gpu.make_buffer(size, usage, {}, Memory::eDeviceLocal, name);
  };
  constexpr vk::BufferUsageFlags kTexels = Usage::eUniformTexelBuffer | Usage::eTransferDst;
  if (upload) {
    frames = local(layout.frame_bytes, kTexels, "frames");
    staging = gpu.make_buffer(layout.frame_bytes, Usage::eTransferSrc, kHost, {}, "staged frames");
    upload_commands_ =
        vk::raii::CommandBuffers(gpu.device, {*gpu.command_pool, vk::CommandBufferLevel::ePrimary, cameras_});
  } else {
    frames = gpu.make_buffer(layout.frame_bytes, kTexels, kHost, Memory::eHostCached, "frames");
    std::memset(frames.mapped, 0, layout.frame_bytes);
  }
  params_ = gpu.make_buffer(sizeof(shaders::CameraParams) * shaders::kMaxCameraCount, Usage::eUniformBuffer,
                            kHost, Memory::eDeviceLocal, "camera parameters");
  std::memset(params_.mapped, 0, params_.size);
  std::copy(layout.params.begin(), layout.params.end(), params().begin());
  constexpr vk::BufferUsageFlags kStorage = Usage::eStorageBuffer | Usage::eTransferDst;
  const vk::DeviceSize counter_bytes =
      sizeof(shaders::DispatchSizes) + sizeof(shaders::CameraCounters) * cameras_;
  counters_ = local(counter_bytes, kStorage | Usage::eTransferSrc | Usage::eIndirectBuffer, "counters");
  cleared_counters_ =
      gpu.make_buffer(counter_bytes, Usage::eTransferSrc, kHost, Memory::eDeviceLocal, "cleared counters");
  header_ = gpu.make_buffer(counter_bytes, Usage::eTransferDst, kHost, Memory::eHostCached,
                            "counters for the host");
  tile_list_ = local(vk::DeviceSize{layout.tiles} * 4, kStorage, "tile list");
  links_ = local(vk::DeviceSize{layout.components} * kLinkBytes,
                 Usage::eStorageTexelBuffer | Usage::eTransferDst, "links");
  sums_ = local(vk::DeviceSize{layout.components} * kSumBytes, Usage::eStorageTexelBuffer, "sums");
  parents_ = local(vk::DeviceSize{layout.components} * 4, kStorage, "parents");
  heads_ = local(vk::DeviceSize{layout.components} * 4, kStorage, "list heads");
  chain_ = local(vk::DeviceSize{layout.components} * 4, kStorage, "list chain");
  divided_ = local(vk::DeviceSize{layout.tiles} * 4, kStorage, "divided tiles");
  pairs_ = local(vk::DeviceSize{layout.tiles} * 16, kStorage, "pairs of tiles");
  roots_ = local(vk::DeviceSize{layout.components} * 4, kStorage, "roots");
  blobs_ = gpu.make_buffer(sizeof(BlobRecord) * options.max_blobs * cameras_, Usage::eStorageBuffer, kHost,
                           Memory::eHostCached, "blobs");
  const auto addresses = [&](vk::DeviceSize size, std::uint64_t most) {
    if (size <= most) return;
    throw Error("Vulkan device \"" + gpu.info.name + "\" addresses only " + std::to_string(most >> 20) +
                " MiB at a time: use fewer or smaller cameras, or fewer max_blobs_per_camera");
  };
  addresses(blobs_.size, gpu.limits.maxStorageBufferRange);
  addresses(heads_.size, gpu.limits.maxStorageBufferRange);
  addresses(sums_.size, std::uint64_t{gpu.limits.maxTexelBufferElements} * kTexelBytes);
  std::memset(cleared_counters_.mapped, 0, counter_bytes);
  const shaders::DispatchSize per_camera{0, cameras_, 1};
  *reinterpret_cast<shaders::DispatchSizes*>(cleared_counters_.mapped) = {{0, 1, 1},  per_camera, per_camera,
                                                                          per_camera, per_camera, {}};
  gpu.run_once([&](vk::raii::CommandBuffer& commands) {
    commands.fillBuffer(*links_.buffer, 0, VK_WHOLE_SIZE, 0);  // no stamp is 0
    commands.fillBuffer(*heads_.buffer, 0, VK_WHOLE_SIZE, 0);
  });
  own_view_.emplace(gpu.make_texel_view(frames));
  links_view_.emplace(gpu.make_texel_view(links_));
  sums_view_.emplace(gpu.make_texel_view(sums_));
  own_set_ = make_set(*own_view_);
  own_frames = record(*own_set_);
  stages_.reserve(kStages.size() + 1);
}

void FrameSetWork::use_adopted_frames(const vk::raii::BufferView& view) {
  adopted_set_ = make_set(view);
  adopted_frames = record(*adopted_set_);
}

vk::raii::DescriptorSet FrameSetWork::make_set(const vk::raii::BufferView& frames_view) {
  const vk::DescriptorSetLayout layout = *pipelines_.set_layout;
  vk::raii::DescriptorSet set = std::move(vk::raii::DescriptorSets(gpu_.device, {*pool_, layout}).front());
  std::array<vk::DescriptorBufferInfo, kBindingCount> infos;
  std::array<vk::BufferView, kBindingCount> views;
  views[kFrames] = *frames_view;
  views[kLimits] = **limits_.limits_view;
  views[kLinks] = **links_view_;
  views[kSums] = **sums_view_;
  const std::array<const VulkanDevice::Buffer*, kBindingCount> buffers{
      &params_,   nullptr,     nullptr, &limits_.tile_floors,
      &counters_, &tile_list_, nullptr, nullptr,
      &parents_,  &heads_,     &chain_, &divided_,
      &pairs_,    &roots_,     &blobs_};
  std::vector<vk::WriteDescriptorSet> writes;
  for (std::uint32_t i = 0; i < kBindingCount; ++i) {
    if (buffers[i] != nullptr) infos[i] = vk::DescriptorBufferInfo(*buffers[i]->buffer, 0, VK_WHOLE_SIZE);
    writes.emplace_back(*set, i, 0, 1, descriptor_type(i), nullptr, &infos[i], &views[i]);
  }
  gpu_.device.updateDescriptorSets(writes, {});
  return set;
}

void FrameSetWork::stamp(const vk::raii::CommandBuffer& commands, std::uint32_t query) const {
  if (gpu_.timestamp_bits == 0) return;
  // Mesa's CPU driver runs dispatches one after the other on the thread that reads the commands, so the top
  // of the pipe is already behind the dispatch before it; waiting for the bottom would wake a second thread.
  commands.writeTimestamp(gpu_.info.software ? Stage::eTopOfPipe : Stage::eBottomOfPipe, *queries_, query);
}

void FrameSetWork::barrier(const vk::raii::CommandBuffer& commands, int number, vk::PipelineStageFlags from,
                           vk::AccessFlags written, vk::PipelineStageFlags to, vk::AccessFlags used) const {
  if (number == omitted_barrier_) return;
  commands.pipelineBarrier(from, to, {}, vk::MemoryBarrier(written, used), {}, {});
}

void FrameSetWork::begin(const vk::raii::CommandBuffer& commands, vk::DescriptorSet set) const {
  commands.begin({});
  commands.bindDescriptorSets(vk::PipelineBindPoint::eCompute, *pipelines_.layout, 0, set, {});
  commands.pushConstants<BlobPushConstants>(*pipelines_.layout, vk::ShaderStageFlagBits::eCompute, 0,
                                            options_);
}

void FrameSetWork::run(const vk::raii::CommandBuffer& commands, std::uint32_t step,
                       std::size_t size_at) const {
  // What the dispatch before wrote -> this one and its size; step 1 comes behind the barrier that ends
  // `always`
  if (step != 1)
    barrier(commands, step == 0 ? 1 : static_cast<int>(step), Stage::eComputeShader, Access::eShaderWrite,
            Stage::eComputeShader | Stage::eDrawIndirect, kReadWrite | Access::eIndirectCommandRead);
  commands.bindPipeline(vk::PipelineBindPoint::eCompute, *pipelines_.blobs[step]);
  commands.dispatchIndirect(*counters_.buffer, size_at);
}

void FrameSetWork::end(const vk::raii::CommandBuffer& commands, int barrier_number) const {
  // Counters -> their copy for the host
  barrier(commands, barrier_number, Stage::eComputeShader, Access::eShaderWrite, Stage::eTransfer,
          Access::eTransferRead);
  commands.copyBuffer(*counters_.buffer, *header_.buffer, vk::BufferCopy(0, 0, counters_.size));
  // Blobs and header -> host; everything -> the commands after these
  barrier(commands, kNeeded, Stage::eComputeShader | Stage::eTransfer,
          Access::eShaderWrite | Access::eTransferRead | Access::eTransferWrite,
          Stage::eComputeShader | Stage::eTransfer | Stage::eDrawIndirect | Stage::eHost,
          kReadWrite | Access::eTransferWrite | Access::eIndirectCommandRead | Access::eHostRead);
  commands.end();
}

FrameSetWork::Commands FrameSetWork::record(vk::DescriptorSet set) const {
  vk::raii::CommandBuffers made(gpu_.device, {*gpu_.command_pool, vk::CommandBufferLevel::ePrimary, 2});
  Commands recorded{std::move(made[0]), std::move(made[1])};
  using Sizes = shaders::DispatchSizes;

  const vk::raii::CommandBuffer& always = recorded.always;
  begin(always, set);
  if (gpu_.timestamp_bits > 0) always.resetQueryPool(*queries_, 0, kUploadQueries);
  always.copyBuffer(*cleared_counters_.buffer, *counters_.buffer, vk::BufferCopy(0, 0, counters_.size));
  // Cleared counters -> counted
  barrier(always, 0, Stage::eTransfer, Access::eTransferWrite, Stage::eComputeShader, kReadWrite);
  stamp(always, 0);
  always.bindPipeline(vk::PipelineBindPoint::eCompute, *pipelines_.candidate_tiles);
  always.dispatch(groups(most_tiles_x_, pipelines_.tiles_group * pipelines_.tiles_steps_across),
                  groups(most_tiles_y_, pipelines_.tiles_rows_down), cameras_);
  stamp(always, 1);
  run(always, 0, offsetof(Sizes, fused));
  stamp(always, 2);
  end(always, 7);

  // Each step has the size that the steps before it found to be needed.
  constexpr std::array sizes{offsetof(Sizes, tiles), offsetof(Sizes, divided), offsetof(Sizes, tiles),
                             offsetof(Sizes, pairs), offsetof(Sizes, tiles),   offsetof(Sizes, roots)};
  const vk::raii::CommandBuffer& many = recorded.many_tiles;
  begin(many, set);
  stamp(many, kManyQueries);
  for (std::uint32_t step = 1; step <= sizes.size(); ++step) {
    run(many, step, sizes[step - 1]);
    stamp(many, kManyQueries + step);
  }
  end(many, kNeeded);
  return recorded;
}

bool FrameSetWork::needs_many_tiles() const noexcept {
  return reinterpret_cast<const shaders::DispatchSizes*>(header_.mapped)->tiles.x > 0;
}

vk::CommandBuffer FrameSetWork::record_upload(std::uint32_t camera, vk::Buffer from,
                                              vk::BufferCopy copy) const {
  const vk::raii::CommandBuffer& commands = upload_commands_[camera];
  const std::uint32_t query = kUploadQueries + 2 * camera;
  commands.begin({vk::CommandBufferUsageFlagBits::eOneTimeSubmit});
  if (gpu_.timestamp_bits > 0) commands.resetQueryPool(*queries_, query, 2);
  stamp(commands, query);
  commands.copyBuffer(from, *frames.buffer, copy);
  stamp(commands, query + 1);
  // This frame -> candidate tiles and everything later
  barrier(commands, kNeeded, Stage::eTransfer, Access::eTransferWrite, Stage::eComputeShader,
          Access::eShaderRead);
  commands.end();
  return *commands;
}

double FrameSetWork::seconds(const std::uint64_t* stamps) const noexcept {
  const std::uint64_t mask =
      gpu_.timestamp_bits >= 64 ? ~std::uint64_t{0} : (std::uint64_t{1} << gpu_.timestamp_bits) - 1;
  return static_cast<double>((stamps[1] - stamps[0]) & mask) * gpu_.info.timestamp_period_ns * 1e-9;
}

bool FrameSetWork::read_stamps(std::uint32_t first, std::span<std::uint64_t> stamps) const noexcept {
  return static_cast<vk::Device>(*gpu_.device)
             .getQueryPoolResults(*queries_, first, static_cast<std::uint32_t>(stamps.size()),
                                  stamps.size_bytes(), stamps.data(), sizeof stamps[0],
                                  vk::QueryResultFlagBits::e64,
                                  *gpu_.device.getDispatcher()) == vk::Result::eSuccess;
}

std::span<const StageTime> FrameSetWork::stages(bool many_tiles_ran) {
  stages_.clear();
  if (gpu_.timestamp_bits == 0) return {};
  if (!upload_commands_.empty()) {
    StageTime upload{"upload", 0.0};
    for (std::uint32_t camera = 0; camera < cameras_; ++camera) {
      std::array<std::uint64_t, 2> stamps{};
      if (params()[camera].stamp != 0 && read_stamps(kUploadQueries + 2 * camera, stamps))
        upload.seconds += seconds(stamps.data());
    }
    stages_.push_back(upload);
  }
  std::array<std::uint64_t, kUploadQueries> stamps{};
  const std::uint32_t count = many_tiles_ran ? kUploadQueries : kManyQueries;
  if (!read_stamps(0, std::span(stamps).first(count))) return {};
  std::size_t stage = 0;
  for (std::uint32_t query = 0; query + 1 < count; ++query) {
    if (query + 1 == kManyQueries) continue;  // between the two command buffers
    stages_.push_back({kStages[stage++], seconds(&stamps[query])});
  }
  return stages_;
}

std::span<shaders::CameraParams> FrameSetWork::params() const {
  return {reinterpret_cast<shaders::CameraParams*>(params_.mapped), cameras_};
}

const shaders::CameraCounters& FrameSetWork::counters(std::uint32_t camera) const noexcept {
  return reinterpret_cast<const shaders::CameraCounters*>(header_.mapped +
                                                          sizeof(shaders::DispatchSizes))[camera];
}

std::span<const BlobRecord> FrameSetWork::records(std::uint32_t camera) const {
  return {reinterpret_cast<const BlobRecord*>(blobs_.mapped) + std::size_t{camera} * options_.max_blobs,
          options_.max_blobs};
}

}  // namespace glint::gpu
