// SPDX-License-Identifier: MIT
// The Vulkan detector: moves frames to the device, submits, waits, sorts.
#include "gpu/vulkan/detector_vulkan.hpp"

#include <algorithm>
#include <cstring>
#include <tuple>

#include "gpu/vulkan/frame_set_work.hpp"

namespace glint::gpu {
namespace {

constexpr std::uint64_t kTimeoutNs = 10'000'000'000;

FramePath choose_path(const VulkanDevice& gpu, FramePath wanted) {
  if (wanted != FramePath::Auto) return wanted;
  // A discrete GPU reads host memory over the bus, pixel by pixel: copy it once instead, camera by camera.
  return gpu.info.type == "discrete" || gpu.info.type == "virtual" ? FramePath::Upload : FramePath::Import;
}

void check_formats(std::span<const CameraFormat> cameras) {
  if (cameras.empty()) throw Error("a detector needs at least one camera");
  if (cameras.size() > kMaxCameras) {
    throw Error(std::to_string(cameras.size()) + " cameras; at most " + std::to_string(kMaxCameras) +
                " are supported");
  }
  for (const CameraFormat& camera : cameras) {
    const std::uint64_t pixels = std::uint64_t{camera.width_px} * camera.height_px;
    if (pixels == 0 || pixels > kMaxPixels || camera.width_px > 65535 || camera.height_px > 65535) {
      throw Error("a camera of " + std::to_string(camera.width_px) + "x" + std::to_string(camera.height_px) +
                  " pixels; between 1 and 2^24 pixels are supported");
    }
  }
}

class VulkanDetector final : public Detector {
 public:
  VulkanDetector(const DeviceInfo& device, std::span<const CameraFormat> cameras,
                 const DetectorOptions& options, const VulkanTestHooks& hooks)
      : cameras_(cameras.begin(), cameras.end()),
        options_(options),
        instance_(options.on_validation_message),
        gpu_(instance_, device),
        pipelines_(gpu_, hooks.fused_tiles),
        layout_(cameras, gpu_.limits),
        path_(choose_path(gpu_, options.frame_path)),
        // A CPU driver pays for every dispatch, needed or not; a GPU for every time that the host is asked.
        submit_together_(hooks.submit_together.value_or(!gpu_.info.software)),
        name_(device.name) {
    check_size();
    using Usage = vk::BufferUsageFlagBits;
    limits_.limits =
        gpu_.make_buffer(vk::DeviceSize{layout_.tiles} * shaders::kTileWidth * shaders::kTileHeight,
                         Usage::eUniformTexelBuffer | Usage::eTransferDst, {},
                         vk::MemoryPropertyFlagBits::eDeviceLocal, "limit images");
    limits_.tile_floors =
        gpu_.make_buffer(vk::DeviceSize{layout_.tiles} * 4, Usage::eStorageBuffer | Usage::eTransferDst, {},
                         vk::MemoryPropertyFlagBits::eDeviceLocal, "tile floors");
    limits_.limits_view.emplace(gpu_.make_texel_view(limits_.limits));
    const BlobPushConstants push{options.min_area_px, options.max_area_px, options.max_blobs_per_camera};
    for (unsigned i = 0; i < std::max(1u, options.depth); ++i) {
      sets_.push_back(std::make_unique<Set>(gpu_, pipelines_, layout_, limits_, push,
                                            path_ == FramePath::Upload, hooks.omitted_barrier));
      Set& set = *sets_.back();
      set.moved.assign(cameras.size(), nullptr);
      set.taken.assign(cameras.size(), nullptr);
      set.sorted.resize(cameras.size());
      for (auto& blobs : set.sorted) blobs.reserve(options.max_blobs_per_camera);
    }
    for (std::uint32_t i = 0; i < cameras.size(); ++i) {
      set_limit(i, std::vector<std::uint8_t>(std::size_t{cameras[i].width_px} * cameras[i].height_px, 255));
    }
    warm_up();
  }

  ~VulkanDetector() override {
    try {
      gpu_.device.waitIdle();
    } catch (const vk::SystemError&) {
      // A lost device has nothing left to wait for.
    }
  }

  const std::string& device_name() const noexcept override { return name_; }
  const std::string& last_error() const noexcept override { return last_error_; }

  void set_limit(std::uint32_t camera, std::span<const std::uint8_t> limit) override {
    if (camera >= cameras_.size() ||
        limit.size() != std::size_t{cameras_[camera].width_px} * cameras_[camera].height_px) {
      throw Error("limit image of camera " + std::to_string(camera + 1) + " has the wrong size");
    }
    if (in_flight_ > 0) throw Error("limit images cannot change while frame sets are in flight");
    shaders::CameraParams& p = layout_.params[camera];
    constexpr std::size_t kTileBytes = shaders::kTileWidth * shaders::kTileHeight;
    const std::size_t tiles = std::size_t{p.tiles_x} * p.tiles_y, floors_at = tiles * kTileBytes;
    const VulkanDevice::Buffer staging =
        gpu_.make_buffer(floors_at + tiles * 4, vk::BufferUsageFlagBits::eTransferSrc,
                         vk::MemoryPropertyFlagBits::eHostVisible | vk::MemoryPropertyFlagBits::eHostCoherent,
                         {}, "staged limits");
    std::memset(staging.mapped, 255, floors_at);     // beyond the image nothing is bright
    for (std::size_t y = 0; y < p.height_px; ++y) {  // tile after tile, row after row within a tile
      const std::size_t first_tile = y / shaders::kTileHeight * p.tiles_x, row = y % shaders::kTileHeight;
      for (std::size_t x = 0; x < p.width_px; x += shaders::kTileWidth) {
        std::memcpy(
            staging.mapped + (first_tile + x / shaders::kTileWidth) * kTileBytes + row * shaders::kTileWidth,
            limit.data() + y * p.width_px + x, std::min<std::size_t>(shaders::kTileWidth, p.width_px - x));
      }
    }
    std::uint32_t lowest = 255;
    for (std::size_t tile = 0; tile < tiles; ++tile) {
      const std::byte* first = staging.mapped + tile * kTileBytes;
      const std::uint32_t floor =
          std::to_integer<std::uint32_t>(*std::min_element(first, first + kTileBytes));
      const std::uint32_t splat = floor * 0x01010101u;
      std::memcpy(staging.mapped + floors_at + tile * 4, &splat, 4);
      lowest = std::min(lowest, floor);
    }
    p.floor_splat = lowest * 0x01010101u;
    gpu_.run_once([&](vk::raii::CommandBuffer& commands) {
      commands.copyBuffer(*staging.buffer, *limits_.limits.buffer,
                          vk::BufferCopy(0, p.tile_base * kTileBytes, floors_at));
      commands.copyBuffer(*staging.buffer, *limits_.tile_floors.buffer,
                          vk::BufferCopy(floors_at, vk::DeviceSize{p.tile_base} * 4, tiles * 4));
    });
    for (const auto& set : sets_) set->work.params()[camera].floor_splat = p.floor_splat;
  }

  bool adopt_frame_memory(std::span<std::byte> memory) override {
    if (path_ == FramePath::Copy || in_flight_ > 0) return false;
    const bool upload = path_ == FramePath::Upload;
    if (!upload && memory.size() / 16 > gpu_.limits.maxTexelBufferElements) return false;
    auto imported = gpu_.import_buffer(
        memory, upload ? vk::BufferUsageFlagBits::eTransferSrc : vk::BufferUsageFlagBits::eUniformTexelBuffer,
        "adopted frames");
    if (!imported) return false;
    adopted_ = std::move(imported);
    adopted_memory_ = memory;
    if (!upload) {
      adopted_view_.emplace(gpu_.make_texel_view(*adopted_));
      for (const auto& set : sets_) set->work.use_adopted_frames(*adopted_view_);
    }
    return true;
  }

  void upload(std::uint32_t camera, const ImageView& image) noexcept override {
    // An adopted frame that the GPU reads in place needs no move; any other is moved as soon as it is here.
    if (camera >= cameras_.size() || in_flight_ == sets_.size() || !fits(camera, image)) return;
    if (path_ == FramePath::Import && readable_in_place(camera, image)) return;
    (void)move_frame(*sets_[next_], camera, image);
  }

  RunStatus submit(std::span<const ImageView> images) noexcept override {
    if (in_flight_ == sets_.size()) return RunStatus::Busy;
    Set& set = *sets_[next_];
    const std::vector<const std::uint8_t*>& moved = set.take_moved();  // by upload(), for this submit or none
    if (images.size() != cameras_.size()) return bad_image("the set does not have one image per camera");
    bool in_place = path_ == FramePath::Import && adopted_.has_value();
    for (std::uint32_t i = 0; i < images.size(); ++i) {
      if (images[i].pixels == nullptr) continue;
      if (!fits(i, images[i]))
        return bad_image("an image of camera " + std::to_string(i + 1) + " has the wrong size");
      in_place = in_place && readable_in_place(i, images[i]);
    }
    const std::span<shaders::CameraParams> params = set.work.params();
    set.stamp += set.stamp == 0xffffffffu ? 2u : 1u;  // 0 is for cameras without a frame
    for (std::uint32_t i = 0; i < images.size(); ++i) {
      const ImageView& image = images[i];
      params[i].stamp = image.pixels != nullptr ? set.stamp : 0;
      if (image.pixels == nullptr) continue;
      if (in_place) {
        params[i].frame_texel = static_cast<std::uint32_t>(offset_in_adopted(image) / 16);
        params[i].stride_texels = image.stride_bytes / 16;
      } else {
        params[i].frame_texel = static_cast<std::uint32_t>(layout_.frame_offset[i] / 16);
        params[i].stride_texels = layout_.params[i].tiles_x;
        if (moved[i] != image.pixels && !move_frame(set, i, image)) return RunStatus::DeviceLost;
      }
    }
    std::fill(set.moved.begin(), set.moved.end(), nullptr);
    set.commands = in_place ? &set.work.adopted_frames : &set.work.own_frames;
    set.many_tiles_started = false;
    const std::array all{*set.commands->always, *set.commands->many_tiles};
    set.many_tiles_started = submit_together_;
    const RunStatus status = start(set, std::span(all).first(set.many_tiles_started ? 2 : 1));
    if (status != RunStatus::Ok) return status;
    next_ = (next_ + 1) % sets_.size();
    ++in_flight_;
    return RunStatus::Ok;
  }

  RunStatus collect(BlobBatch& batch) noexcept override {
    if (in_flight_ == 0) return RunStatus::Idle;
    const std::size_t oldest = (next_ + sets_.size() - in_flight_) % sets_.size();
    Set& set = *sets_[oldest];
    if (const RunStatus status = wait(set); status != RunStatus::Ok) return status;
    if (!set.many_tiles_started && set.work.needs_many_tiles()) {
      if (const RunStatus status = start(set, {{*set.commands->many_tiles}}); status != RunStatus::Ok)
        return status;
      set.many_tiles_started = true;  // a caller may come back after a time-out
      if (const RunStatus status = wait(set); status != RunStatus::Ok) return status;
    }
    --in_flight_;
    batch.cameras.resize(cameras_.size());
    for (std::uint32_t i = 0; i < cameras_.size(); ++i) {
      const shaders::CameraCounters& counters = set.work.counters(i);
      const std::span<const BlobRecord> records = set.work.records(i);
      const std::size_t kept = std::min<std::size_t>(counters.blobs, records.size());
      std::vector<BlobRecord>& sorted = set.sorted[i];
      sorted.assign(records.begin(), records.begin() + static_cast<std::ptrdiff_t>(kept));
      std::sort(sorted.begin(), sorted.end(), [](const BlobRecord& a, const BlobRecord& b) {
        return std::tie(a.y_min_px, a.x_min_px, a.area_px, a.sum) <
               std::tie(b.y_min_px, b.x_min_px, b.area_px, b.sum);
      });
      batch.cameras[i] = {sorted, counters.blobs, counters.blobs > kept || counters.flags != 0};
    }
    const std::span<const StageTime> stages = set.work.stages(set.many_tiles_started);
    batch.stages.assign(stages.begin(), stages.end());
    return RunStatus::Ok;
  }

 private:
  struct Set {
    Set(const VulkanDevice& gpu, const Pipelines& pipelines, const WorkLayout& layout,
        const LimitBuffers& limits, const BlobPushConstants& push, bool upload, int omitted_barrier)
        : work(gpu, pipelines, layout, limits, push, upload, omitted_barrier) {}
    /// What upload() moved for the submit that asks; forgotten then, whatever comes of it.
    const std::vector<const std::uint8_t*>& take_moved() noexcept {
      moved.swap(taken);
      std::fill(moved.begin(), moved.end(), nullptr);
      return taken;
    }
    FrameSetWork work;
    const FrameSetWork::Commands* commands = nullptr;  // of the set in flight
    bool many_tiles_started = false;
    std::uint32_t stamp = 0;  // tells this frame set from the ones before it on the device
    std::vector<const std::uint8_t*> moved, taken;  // per camera: pixels that are on their way
    std::vector<std::vector<BlobRecord>> sorted;
  };

  void check_size() const {
    if (path_ != FramePath::Import || layout_.frame_bytes / 16 <= gpu_.limits.maxTexelBufferElements) return;
    throw Error("Vulkan device \"" + name_ + "\" addresses only " +
                std::to_string(std::uint64_t{gpu_.limits.maxTexelBufferElements} * 16 >> 20) +
                " MiB of frames: use fewer or smaller cameras");
  }

  // Drivers compile a pipeline for good when it first runs, Mesa's CPU driver for half a second: not within
  // the loop.
  void warm_up() {
    Set& set = *sets_.front();
    for (const vk::raii::CommandBuffer* commands :
         {&set.work.own_frames.always, &set.work.own_frames.many_tiles}) {
      if (start(set, {{**commands}}) != RunStatus::Ok || wait(set) != RunStatus::Ok)  // of no camera
        throw Error(last_error_);
    }
  }

  bool fits(std::uint32_t camera, const ImageView& image) const noexcept {
    return image.pixels != nullptr && image.width_px == cameras_[camera].width_px &&
           image.height_px == cameras_[camera].height_px && image.stride_bytes >= image.width_px;
  }

  std::size_t offset_in_adopted(const ImageView& image) const noexcept {
    return static_cast<std::size_t>(reinterpret_cast<std::uintptr_t>(image.pixels) -
                                    reinterpret_cast<std::uintptr_t>(adopted_memory_.data()));
  }

  bool inside_adopted(const ImageView& image, std::size_t bytes) const noexcept {
    const auto at = reinterpret_cast<std::uintptr_t>(image.pixels);
    const auto base = reinterpret_cast<std::uintptr_t>(adopted_memory_.data());
    return adopted_ && at >= base && at - base + bytes <= adopted_memory_.size();
  }

  // The shaders read whole tiles: up to 7 rows below the image must be inside the memory too.
  bool readable_in_place(std::uint32_t camera, const ImageView& image) const noexcept {
    const std::size_t rows = std::size_t{layout_.params[camera].tiles_y} * shaders::kTileHeight;
    return image.stride_bytes % 16 == 0 && image.stride_bytes >= layout_.stride_bytes(camera) &&
           inside_adopted(image, image.stride_bytes * rows) && offset_in_adopted(image) % 16 == 0;
  }

  // Into the set's own frame buffer: by the CPU, or on a discrete GPU by its copy engine.
  bool move_frame(Set& set, std::uint32_t camera, const ImageView& image) noexcept {
    const std::size_t stride = layout_.stride_bytes(camera), offset = layout_.frame_offset[camera];
    const std::size_t bytes = stride * image.height_px;
    // An earlier frame of this set may still be copied out of the same staging memory by the same commands.
    if (path_ == FramePath::Upload && (set.moved[camera] != nullptr || set.taken[camera] != nullptr)) {
      try {
        gpu_.queue.waitIdle();
      } catch (const std::exception& e) {
        (void)lost(e.what());
        return false;
      }
    }
    set.moved[camera] = image.pixels;
    const bool adopted =
        path_ == FramePath::Upload && image.stride_bytes == stride && inside_adopted(image, bytes);
    if (!adopted) {
      std::byte* target = (path_ == FramePath::Upload ? set.work.staging : set.work.frames).mapped + offset;
      if (image.stride_bytes == stride) {
        std::memcpy(target, image.pixels, bytes - (stride - image.width_px));
      } else {
        for (std::uint32_t y = 0; y < image.height_px; ++y) {
          std::memcpy(target + y * stride, image.pixels + std::size_t{y} * image.stride_bytes,
                      image.width_px);
        }
      }
    }
    if (path_ != FramePath::Upload) return true;
    try {
      const vk::CommandBuffer raw =
          set.work.record_upload(camera, adopted ? *adopted_->buffer : *set.work.staging.buffer,
                                 vk::BufferCopy(adopted ? offset_in_adopted(image) : offset, offset, bytes));
      gpu_.queue.submit(vk::SubmitInfo({}, {}, raw));
      return true;
    } catch (const std::exception& e) {
      (void)lost(e.what());
      return false;
    }
  }

  RunStatus start(Set& set, std::span<const vk::CommandBuffer> commands) noexcept {
    try {
      gpu_.device.resetFences(*set.work.done);
      gpu_.queue.submit(
          vk::SubmitInfo(0, nullptr, nullptr, static_cast<std::uint32_t>(commands.size()), commands.data()),
          *set.work.done);
      return RunStatus::Ok;
    } catch (const std::exception& e) {
      return lost(e.what());
    }
  }

  RunStatus wait(const Set& set) noexcept {
    try {
      if (gpu_.device.waitForFences(*set.work.done, true, kTimeoutNs) != vk::Result::eTimeout)
        return RunStatus::Ok;
      last_error_ = "Vulkan device \"" + name_ + "\" did not finish a frame set within 10 s";
      return RunStatus::Timeout;
    } catch (const std::exception& e) {
      return lost(e.what());
    }
  }

  RunStatus bad_image(std::string text) noexcept {
    last_error_ = std::move(text);
    return RunStatus::BadImage;
  }

  RunStatus lost(const char* what) noexcept {
    last_error_ = "Vulkan device \"" + name_ + "\" failed: " + what;
    return RunStatus::DeviceLost;
  }

  std::vector<CameraFormat> cameras_;
  DetectorOptions options_;
  VulkanInstance instance_;
  VulkanDevice gpu_;
  Pipelines pipelines_;
  WorkLayout layout_;
  FramePath path_;
  bool submit_together_;
  std::string name_, last_error_;
  LimitBuffers limits_;
  std::optional<VulkanDevice::Buffer> adopted_;
  std::optional<vk::raii::BufferView> adopted_view_;
  std::span<std::byte> adopted_memory_;
  std::vector<std::unique_ptr<Set>> sets_;
  std::size_t next_ = 0, in_flight_ = 0;
};

}  // namespace

std::unique_ptr<Detector> make_vulkan_detector(const DeviceInfo& device,
                                               std::span<const CameraFormat> cameras,
                                               const DetectorOptions& options, const VulkanTestHooks& hooks) {
  check_formats(cameras);
  try {
    return std::make_unique<VulkanDetector>(device, cameras, options, hooks);
  } catch (const vk::SystemError& e) {
    throw Error("Vulkan device \"" + device.name + "\" failed during set-up: " + e.what());
  }
}

std::vector<DeviceInfo> list_devices(std::string* problem) {
  try {
    std::vector<DeviceInfo> devices = VulkanInstance().devices();
    if (devices.empty() && problem != nullptr)
      *problem = "no Vulkan driver is installed (Mesa: mesa-vulkan-drivers)";
    return devices;
  } catch (const std::exception& e) {
    if (problem != nullptr) *problem = e.what();
    return {};
  }
}

}  // namespace glint::gpu
