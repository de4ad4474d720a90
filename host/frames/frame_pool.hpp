// SPDX-License-Identifier: MIT
// Page-aligned memory for frames, allocated once, lent as move-only Frames.
#pragma once

#include <array>
#include <atomic>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "gpu/detector.hpp"
#include "host/base/ids.hpp"

namespace glint {

struct FrameSize {
  std::uint32_t width_px = 0, height_px = 0;
};

class FramePool;

/// What the driver's time stamp marks.
enum class StampPoint : std::uint8_t { StartOfExposure, MiddleOfExposure, EndOfFrame, HostArrival };

/// One image of one camera. Move-only; gives its slot back to the pool when destroyed.
class Frame {
 public:
  Frame() = default;
  Frame(Frame&& other) noexcept { *this = std::move(other); }
  Frame& operator=(Frame&& other) noexcept;
  Frame(const Frame&) = delete;
  Frame& operator=(const Frame&) = delete;
  ~Frame() { release(); }

  CameraId camera{};
  std::uint32_t sequence = 0;  ///< from the driver or the file; a gap is a lost frame
  Timestamp stamped{};
  StampPoint stamp = StampPoint::HostArrival;
  bool damaged = false;  ///< the driver or the decoder said so; must not be detected on
  /// Frames of one run follow each other as regularly as the pulses do: their stamps and sequence numbers
  /// advance alike. Between two runs the camera may have slipped by whole pulses. Set where frames are
  /// paired.
  std::uint32_t run = 0;
  int shifted = 0;  ///< so many pulses later than its stamp says, because FrameSource::shift() asked for it

  /// Writable pixels of the slot: height_px rows of stride_bytes.
  std::span<std::uint8_t> pixels() noexcept;
  std::uint32_t stride_bytes() const noexcept;
  gpu::ImageView image() const noexcept;

 private:
  friend class FramePool;
  Frame(FramePool* pool, std::uint32_t slot) noexcept : pool_(pool), slot_(slot) {}
  void release() noexcept;
  FramePool* pool_ = nullptr;
  std::uint32_t slot_ = 0;
};

/// `slots_per_camera` slots for each camera in one page-aligned slab. Slots start on page boundaries, strides
/// are multiples of 16 bytes, and rows are padded to a multiple of 8, so that the GPU reads whole tiles.
/// take() is called by one thread per camera; frames may be returned by any thread. Lock-free. All frames
/// must be back before the pool ends.
class FramePool {
 public:
  /// Throws Error when the memory is not to be had or a size is out of range.
  FramePool(std::vector<FrameSize> cameras, std::uint32_t slots_per_camera);
  ~FramePool();
  FramePool(const FramePool&) = delete;
  FramePool& operator=(const FramePool&) = delete;

  /// A free slot of that camera, its old pixels still in it; nothing when all are lent.
  std::optional<Frame> take(CameraId camera) noexcept;
  std::span<std::byte> memory() noexcept { return {memory_, bytes_}; }
  std::size_t cameras() const noexcept { return cameras_.size(); }
  FrameSize size(CameraId camera) const noexcept { return cameras_[index(camera)].size; }

 private:
  friend class Frame;
  struct Camera {
    FrameSize size;
    std::uint32_t stride_bytes = 0;
    std::size_t slot_bytes = 0, offset = 0;
  };
  std::uint8_t* slot_pixels(std::uint32_t slot) const noexcept;
  std::vector<Camera> cameras_;
  std::uint32_t slots_per_camera_ = 0;
  std::unique_ptr<std::atomic<bool>[]> lent_;  // index: camera * slots_per_camera + n
  std::byte* memory_ = nullptr;
  std::size_t bytes_ = 0;
};

/// What live cameras tell of a frame set beside its pictures.
struct LiveTimes {
  Timestamp stamped{};                         ///< latest of its frames' stamps
  StampPoint stamp = StampPoint::HostArrival;  ///< what that stamp marks
  Timestamp arrived{};                         ///< when the last frame had come, before it waited for others
  /// Half-width of an interval about FrameSet::exposed that holds the middle of the exposure.
  double exposed_error_s = 0.0;
};

/// One exposure of the rig; a camera's frame may be missing.
struct FrameSet {
  TriggerNo trigger{};
  Timestamp exposed{};    ///< middle of the exposure; for recordings without clocks trigger / rate
  Timestamp delivered{};  ///< when the last byte was in host memory
  std::array<std::optional<Frame>, gpu::kMaxCameras> frames;
  bool dark = false;  ///< the sync board says that the light was off; false without a board
  std::optional<LiveTimes>
      live;  ///< only where stamps are of the host's clock: not of recordings, nor simulated
};

}  // namespace glint
