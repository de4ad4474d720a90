// SPDX-License-Identifier: MIT
// Memory and commands of one frame set in flight.
#include "gpu/vulkan/frame_set_work.hpp"

#include <algorithm>
#include <cstring>

namespace glint::gpu {
namespace {

using Usage = vk::BufferUsageFlagBits;
using Memory = vk::MemoryPropertyFlagBits;
using Stage = vk::PipelineStageFlagBits;
using Access = vk::AccessFlagBits;

constexpr vk::MemoryPropertyFlags kHost = Memory::eHostVisible | Memory::eHostCoherent;
// Two stamps around the first two dispatches and the one between them, as many again around the large ones.
constexpr std::uint32_t kLargeQueries = 3, kQueries = kLargeQueries + 5;

constexpr vk::AccessFlags kReadWrite = Access::eShaderRead | Access::eShaderWrite;
constexpr int kNeeded = -2;  // barriers that are not among the numbered ones: kBarriers says why

std::uint32_t groups(std::uint32_t items, std::uint32_t each) { return (items + each - 1) / each; }

vk::raii::DescriptorPool make_pool(const VulkanDevice& gpu) {
  const std::array sizes{vk::DescriptorPoolSize(vk::DescriptorType::eUniformBuffer, 2),
                         vk::DescriptorPoolSize(vk::DescriptorType::eUniformTexelBuffer, 4),
                         vk::DescriptorPoolSize(vk::DescriptorType::eStorageBuffer, 2 * (kBindingCount - 3))};
  return {gpu.device,
          vk::DescriptorPoolCreateInfo(vk::DescriptorPoolCreateFlagBits::eFreeDescriptorSet, 2, sizes)};
}

}  // namespace

WorkLayout::WorkLayout(std::span<const CameraFormat> cameras, std::uint32_t largest_buffer_bytes) {
  std::uint64_t all_tiles = 0;
  for (const CameraFormat& camera : cameras) {
    all_tiles += std::uint64_t{groups(camera.width_px, shaders::kTileWidth)} *
                 (groups(camera.height_px, shaders::kTileHeight));
  }
  // A tile holds at most 32 components. On a device whose largest buffer is too small for that, images with
  // many components in every tile overflow before they have more blobs than there is room for.
  const std::uint64_t fit = largest_buffer_bytes / (all_tiles * kSumFields * 4);
  const auto extra_per_tile = static_cast<std::uint32_t>(std::clamp<std::uint64_t>(fit, 2, 32) - 1);
  std::uint32_t limit_texels = 0;
  for (const CameraFormat& camera : cameras) {
    shaders::CameraParams p{};
    p.width_px = camera.width_px;
    p.height_px = camera.height_px;
    p.tiles_x = groups(camera.width_px, shaders::kTileWidth);
    p.tiles_y = groups(camera.height_px, shaders::kTileHeight);
    const std::uint32_t camera_tiles = p.tiles_x * p.tiles_y;
    p.limit_texel = limit_texels;
    p.tile_base = tiles;
    p.slot_base = slots;
    p.extra_slots = extra_per_tile * camera_tiles;
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
    limit_texels += p.tiles_x * rows;
    tiles += camera_tiles;
    slots += camera_tiles + p.extra_slots;
    most_tiles_x = std::max(most_tiles_x, p.tiles_x);
    most_tiles_y = std::max(most_tiles_y, p.tiles_y);
  }
  limit_bytes = vk::DeviceSize{limit_texels} * 16;
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
      queries_(gpu.device, vk::QueryPoolCreateInfo({}, vk::QueryType::eTimestamp, kQueries)) {
  const auto local = [&](vk::DeviceSize size, vk::BufferUsageFlags usage, const char* name) {
    return gpu.make_buffer(size, usage, {}, Memory::eDeviceLocal, name);
  };
  constexpr vk::BufferUsageFlags kTexels = Usage::eUniformTexelBuffer | Usage::eTransferDst;
  if (upload) {
    frames = local(layout.frame_bytes, kTexels, "frames");
    staging = gpu.make_buffer(layout.frame_bytes, Usage::eTransferSrc, kHost, {}, "staged frames");
    upload_commands =
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
  counters_ = local(sizeof(shaders::CameraCounters) * cameras_, kStorage | Usage::eTransferSrc, "counters");
  tile_list_ = local(layout.tiles * 4, kStorage, "tile list");
  tile_map_ = local(layout.tiles * 4, kStorage, "tile map");
  parents_ = local(vk::DeviceSize{layout.slots} * 4, kStorage, "parents");
  links_ = local(vk::DeviceSize{layout.slots} * 16, kStorage, "links");
  sums_ = local(vk::DeviceSize{layout.slots} * 4 * kSumFields, kStorage, "sums");
  roots_ = local(vk::DeviceSize{layout.slots} * 4, kStorage, "roots");
  blobs_ = gpu.make_buffer(sizeof(BlobRecord) * options.max_blobs * cameras_, Usage::eStorageBuffer, kHost,
                           Memory::eHostCached, "blobs");
  header_ = gpu.make_buffer(counters_.size, Usage::eStorageBuffer, kHost, Memory::eHostCached,
                            "counters for the host");
  large_header_ =
      gpu.make_buffer(counters_.size, Usage::eTransferDst, kHost, Memory::eHostCached, "large counters");
  if (sums_.size > gpu.limits.maxStorageBufferRange || blobs_.size > gpu.limits.maxStorageBufferRange) {
    throw Error("Vulkan device \"" + gpu.info.name + "\" addresses only " +
                std::to_string(gpu.limits.maxStorageBufferRange >> 20) +
                " MiB at a time: use fewer or smaller cameras, or fewer max_blobs_per_camera");
  }
  gpu.run_once([&](vk::raii::CommandBuffer& commands) {
    commands.fillBuffer(*tile_map_.buffer, 0, VK_WHOLE_SIZE, 0);
    commands.fillBuffer(*counters_.buffer, 0, VK_WHOLE_SIZE, 0);
  });
  own_view_.emplace(gpu.make_texel_view(frames));
  own_set_ = make_set(*own_view_);
  own_frames = record(own_set_);
}

void FrameSetWork::use_adopted_frames(const vk::raii::BufferView& view) {
  adopted_set_ = make_set(view);
  adopted_frames = record(adopted_set_);
}

vk::raii::DescriptorSet FrameSetWork::make_set(const vk::raii::BufferView& frames_view) {
  const vk::DescriptorSetLayout layout = *pipelines_.set_layout;
  vk::raii::DescriptorSet set = std::move(vk::raii::DescriptorSets(gpu_.device, {*pool_, layout}).front());
  std::vector<vk::DescriptorBufferInfo> infos(kBindingCount);
  const std::array<const VulkanDevice::Buffer*, kBindingCount> buffers{
      &params_,   nullptr,     nullptr,    &limits_.tile_floors,
      &counters_, &tile_list_, &tile_map_, &parents_,
      &links_,    &sums_,      &blobs_,    &header_,
      &roots_};
  const vk::BufferView frames_raw = *frames_view, limits_raw = **limits_.limits_view;
  std::vector<vk::WriteDescriptorSet> writes;
  for (std::uint32_t i = 0; i < kBindingCount; ++i) {
    if (i == kFrames || i == kLimits) {
      writes.emplace_back(*set, i, 0, 1, vk::DescriptorType::eUniformTexelBuffer, nullptr, nullptr,
                          i == kFrames ? &frames_raw : &limits_raw);
    } else {
      infos[i] = vk::DescriptorBufferInfo(*buffers[i]->buffer, 0, VK_WHOLE_SIZE);
      writes.emplace_back(
          *set, i, 0, 1,
          i == kCameras ? vk::DescriptorType::eUniformBuffer : vk::DescriptorType::eStorageBuffer, nullptr,
          &infos[i]);
    }
  }
  gpu_.device.updateDescriptorSets(writes, {});
  return set;
}

void FrameSetWork::begin(const vk::raii::CommandBuffer& commands, vk::DescriptorSet set) const {
  commands.begin({});
  commands.bindDescriptorSets(vk::PipelineBindPoint::eCompute, *pipelines_.layout, 0, set, {});
  commands.pushConstants<BlobPushConstants>(*pipelines_.layout, vk::ShaderStageFlagBits::eCompute, 0,
                                            options_);
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

FrameSetWork::Commands FrameSetWork::record(const vk::raii::DescriptorSet& set) const {
  vk::raii::CommandBuffers made(gpu_.device, {*gpu_.command_pool, vk::CommandBufferLevel::ePrimary, 2});
  Commands recorded{std::move(made[0]), std::move(made[1]), *set};
  const vk::raii::CommandBuffer& always = recorded.always;
  begin(always, *set);
  if (gpu_.timestamp_bits > 0) always.resetQueryPool(*queries_, 0, kQueries);
  stamp(always, 0);
  always.bindPipeline(vk::PipelineBindPoint::eCompute, *pipelines_.candidate_tiles);
  always.dispatch(groups(most_tiles_x_, pipelines_.tiles_group * pipelines_.tiles_steps_across),
                  groups(most_tiles_y_, pipelines_.tiles_rows_down), cameras_);
  stamp(always, 1);
  // Candidate tiles: list, map and counters -> fused step
  barrier(always, 0, Stage::eComputeShader, Access::eShaderWrite, Stage::eComputeShader, kReadWrite);
  always.bindPipeline(vk::PipelineBindPoint::eCompute, *pipelines_.blobs[0]);
  always.dispatch(cameras_, 1, 1);
  stamp(always, 2);
  // Fused step: blobs and header -> host; cleared counters and tile map -> the next set
  barrier(always, kNeeded, Stage::eComputeShader, Access::eShaderWrite, Stage::eComputeShader | Stage::eHost,
          kReadWrite | Access::eHostRead);
  always.end();
  return recorded;
}

void FrameSetWork::record_large(const Commands& commands) const {
  const std::uint32_t tile_groups = std::max(1u, groups(largest_tiles(), kSplitGroup));
  const vk::raii::CommandBuffer& large = commands.large;
  begin(large, commands.set);
  // Candidate tiles and counters of the commands above -> step 1
  barrier(large, kNeeded, Stage::eComputeShader, Access::eShaderWrite, Stage::eComputeShader, kReadWrite);
  stamp(large, kLargeQueries);
  for (std::uint32_t step = 1; step <= 4; ++step) {
    large.bindPipeline(vk::PipelineBindPoint::eCompute, *pipelines_.blobs[step]);
    large.dispatch(tile_groups, cameras_, 1);
    stamp(large, kLargeQueries + step);
    // 1: components -> joined; 2: parents -> summed; 3: sums -> emitted
    if (step < 4)
      barrier(large, static_cast<int>(step), Stage::eComputeShader, Access::eShaderWrite,
              Stage::eComputeShader, kReadWrite);
  }
  // Emitted: counters -> their copy for the host -> cleared for the next set
  barrier(large, 4, Stage::eComputeShader, Access::eShaderWrite, Stage::eTransfer, Access::eTransferRead);
  large.copyBuffer(*counters_.buffer, *large_header_.buffer, vk::BufferCopy(0, 0, counters_.size));
  barrier(large, 5, Stage::eTransfer, Access::eTransferRead, Stage::eTransfer, Access::eTransferWrite);
  large.fillBuffer(*counters_.buffer, 0, VK_WHOLE_SIZE, 0);
  // Cleared counters -> the next set's candidate tiles; blobs and header -> host
  barrier(large, kNeeded, Stage::eComputeShader | Stage::eTransfer,
          Access::eShaderWrite | Access::eTransferWrite, Stage::eComputeShader | Stage::eHost,
          kReadWrite | Access::eHostRead);
  large.end();
}

std::span<const double> FrameSetWork::stage_seconds(bool large_ran) {
  if (gpu_.timestamp_bits == 0) return {};
  std::array<std::uint64_t, kQueries> ticks{};
  const std::uint32_t count = large_ran ? kQueries : kLargeQueries;
  const auto result =
      static_cast<vk::Device>(*gpu_.device)
          .getQueryPoolResults(*queries_, 0, count, sizeof ticks, ticks.data(), sizeof ticks[0],
                               vk::QueryResultFlagBits::e64, *gpu_.device.getDispatcher());
  if (result != vk::Result::eSuccess) return {};
  const std::uint64_t mask =
      gpu_.timestamp_bits >= 64 ? ~std::uint64_t{0} : (std::uint64_t{1} << gpu_.timestamp_bits) - 1;
  std::size_t stage = 0;
  for (std::uint32_t query = 0; query + 1 < count; ++query) {
    if (query + 1 == kLargeQueries) continue;  // between the two command buffers
    stage_seconds_[stage++] =
        static_cast<double>((ticks[query + 1] - ticks[query]) & mask) * gpu_.info.timestamp_period_ns * 1e-9;
  }
  return {stage_seconds_.data(), stage};
}

std::uint32_t FrameSetWork::largest_tiles() const noexcept {
  std::uint32_t most = 0;
  for (std::uint32_t camera = 0; camera < cameras_; ++camera) {
    most = std::max(most, reinterpret_cast<const shaders::CameraCounters*>(header_.mapped)[camera].tiles);
  }
  return most;
}

std::span<shaders::CameraParams> FrameSetWork::params() const {
  return {reinterpret_cast<shaders::CameraParams*>(params_.mapped), cameras_};
}

const shaders::CameraCounters& FrameSetWork::counters(std::uint32_t camera) const noexcept {
  const auto* fused = reinterpret_cast<const shaders::CameraCounters*>(header_.mapped) + camera;
  if (fused->tiles <= pipelines_.fused_tiles) return *fused;
  return reinterpret_cast<const shaders::CameraCounters*>(large_header_.mapped)[camera];
}

std::span<const BlobRecord> FrameSetWork::records(std::uint32_t camera) const {
  return {reinterpret_cast<const BlobRecord*>(blobs_.mapped) + std::size_t{camera} * options_.max_blobs,
          options_.max_blobs};
}

}  // namespace glint::gpu
