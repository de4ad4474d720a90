// SPDX-License-Identifier: MIT
// The slab behind all frames: one anonymous mapping, one flag per slot.
#include "host/frames/frame_pool.hpp"

#include <sys/mman.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <limits>
#include <string>
#include <utility>

#include "host/base/check.hpp"
#include "host/base/error.hpp"

namespace glint {
namespace {

constexpr std::size_t kStrideMultiple = 16;  // the detectors read 16 pixels at a time
constexpr std::size_t kRowMultiple = 8;      // ... in tiles 8 rows high

std::size_t round_up(std::size_t value, std::size_t multiple) noexcept {
  return (value + multiple - 1) / multiple * multiple;
}

}  // namespace

Frame& Frame::operator=(Frame&& other) noexcept {
  if (this == &other) return *this;
  release();
  camera = other.camera;
  sequence = other.sequence;
  stamped = other.stamped;
  stamp = other.stamp;
  damaged = other.damaged;
  run = other.run;
  shifted = other.shifted;
  pool_ = std::exchange(other.pool_, nullptr);
  slot_ = std::exchange(other.slot_, 0);
  return *this;
}

void Frame::release() noexcept {
  if (pool_ == nullptr) return;
  FramePool& pool = *std::exchange(pool_, nullptr);
  // Release: what this thread did to the pixels is done before another thread takes the slot.
  GLINT_CHECK(pool.lent_[slot_].exchange(false, std::memory_order_release));
}

std::span<std::uint8_t> Frame::pixels() noexcept {
  if (pool_ == nullptr) return {};
  const auto& camera_memory = pool_->cameras_[slot_ / pool_->slots_per_camera_];
  return {pool_->slot_pixels(slot_), std::size_t{camera_memory.size.height_px} * camera_memory.stride_bytes};
}

std::uint32_t Frame::stride_bytes() const noexcept {
  return pool_ == nullptr ? 0 : pool_->cameras_[slot_ / pool_->slots_per_camera_].stride_bytes;
}

gpu::ImageView Frame::image() const noexcept {
  if (pool_ == nullptr) return {};
  const auto& camera_memory = pool_->cameras_[slot_ / pool_->slots_per_camera_];
  return {pool_->slot_pixels(slot_), camera_memory.size.width_px, camera_memory.size.height_px,
          camera_memory.stride_bytes, gpu::PixelFormat::Grey8};
}

FramePool::FramePool(std::vector<FrameSize> cameras, std::uint32_t slots_per_camera)
    : slots_per_camera_(slots_per_camera) {
  GLINT_CHECK(slots_per_camera > 0);
  if (cameras.empty() || cameras.size() > gpu::kMaxCameras) {
    throw Error("a frame pool needs 1 to " + std::to_string(gpu::kMaxCameras) + " cameras, not " +
                std::to_string(cameras.size()));
  }
  const auto page_bytes = static_cast<std::size_t>(sysconf(_SC_PAGESIZE));
  cameras_.reserve(cameras.size());
  for (const FrameSize size : cameras) {
    if (size.width_px == 0 || size.height_px == 0 ||
        std::uint64_t{size.width_px} * size.height_px > gpu::kMaxPixels) {
      throw Error("camera " + std::to_string(cameras_.size()) + " has frames of " +
                  std::to_string(size.width_px) + "x" + std::to_string(size.height_px) +
                  " pixels; possible are 1x1 up to " + std::to_string(gpu::kMaxPixels) + " pixels in all");
    }
    Camera camera;
    camera.size = size;
    camera.stride_bytes = static_cast<std::uint32_t>(round_up(size.width_px, kStrideMultiple));
    camera.slot_bytes = round_up(round_up(size.height_px, kRowMultiple) * camera.stride_bytes, page_bytes);
    camera.offset = bytes_;
    bytes_ += camera.slot_bytes * slots_per_camera;
    cameras_.push_back(camera);
  }
  const std::uint64_t slots = std::uint64_t{slots_per_camera} * cameras_.size();
  if (slots > std::numeric_limits<std::uint32_t>::max()) {
    throw Error("no memory for " + std::to_string(slots) + " frames; use fewer");
  }
  lent_ = std::make_unique<std::atomic<bool>[]>(slots);

  // MAP_POPULATE: every page exists before the loop runs, so that the frame path has no page faults.
  void* const mapped =
      mmap(nullptr, bytes_, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS | MAP_POPULATE, -1, 0);
  if (mapped == MAP_FAILED) {
    throw Error("no memory for " + std::to_string(slots_per_camera) + " frames of " +
                std::to_string(cameras_.size()) + " cameras (" + std::to_string(bytes_ >> 20) +
                " MiB): " + std::strerror(errno) + "; use fewer or smaller frames");
  }
  memory_ = static_cast<std::byte*>(mapped);
}

FramePool::~FramePool() {
  for (std::size_t slot = 0; slot < cameras_.size() * slots_per_camera_; ++slot) {
    // A frame that outlives its pool would write into memory that is gone.
    GLINT_CHECK(!lent_[slot].load(std::memory_order_acquire));
  }
  munmap(memory_, bytes_);
}

std::optional<Frame> FramePool::take(CameraId camera) noexcept {
  GLINT_CHECK(index(camera) < cameras_.size());
  const auto first = static_cast<std::uint32_t>(index(camera)) * slots_per_camera_;
  for (std::uint32_t slot = first; slot < first + slots_per_camera_; ++slot) {
    bool free = false;
    if (lent_[slot].compare_exchange_strong(free, true, std::memory_order_acquire,
                                            std::memory_order_relaxed)) {
      Frame frame(this, slot);
      frame.camera = camera;
      return frame;
    }
  }
  return std::nullopt;
}

std::uint8_t* FramePool::slot_pixels(std::uint32_t slot) const noexcept {
  const Camera& camera = cameras_[slot / slots_per_camera_];
  // The slab is raw bytes; pixels are bytes too.
  return reinterpret_cast<std::uint8_t*>(memory_ + camera.offset +
                                         camera.slot_bytes * (slot % slots_per_camera_));
}

}  // namespace glint
