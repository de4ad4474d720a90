// SPDX-License-Identifier: MIT
// One camera that streams: its buffers, its faults, and grey frames out of it.
#pragma once

#include <chrono>
#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "host/capture/jpeg/jpeg_decoder.hpp"
#include "host/capture/v4l2/camera_controls.hpp"
#include "host/capture/v4l2/camera_formats.hpp"
#include "host/capture/v4l2/camera_list.hpp"
#include "host/frames/frame_pool.hpp"

namespace glint {

struct CameraRequest {
  std::string name;    ///< the rig's
  std::string device;  ///< see open_camera()
  WantedFormat format;
  std::vector<ControlSetting> controls;
  double pulse_rate_hz =
      0.0;  ///< frames that should come, the watchdog's measure; 0: what the driver is set to
};

/// Why a frame that came cannot be used.
enum class FrameFlaw : std::uint8_t {
  None,
  Flagged,        ///< the driver says that it is damaged
  Short,          ///< fewer bytes than a picture has
  TruncatedJpeg,  ///< no end marker
  CorruptJpeg,
  WrongSize,  ///< a JPEG of another size
  NoSlot,     ///< the frame pool had no room: dropped by us
  TooOld,     ///< a JPEG that waited for two periods: dropped by us, as decoding it would delay newer ones
};
inline constexpr std::size_t kFrameFlaws = 8;

struct ReceivedFrame {
  Frame frame;  ///< sequence, stamped, stamp and damaged are set; without pixels if damaged
  Timestamp arrived{};
  FrameFlaw flaw = FrameFlaw::None;
};

enum class StreamStatus : std::uint8_t {
  Nothing,    ///< no frame within the time given
  Frame,      ///< one is there, good or not
  Unplugged,  ///< the device is gone
  Broken,     ///< the driver has given up; problem() says how. Closing and opening again may help
};

/// Thread-bound. Between start() and stop() nothing is allocated.
class CameraStream {
 public:
  /// Opens the camera, sets format and controls. Throws Error that names the camera.
  CameraStream(DeviceCalls& calls, const DeviceRoots& roots, const CameraRequest& request);
  ~CameraStream() { stop(); }
  CameraStream(const CameraStream&) = delete;
  CameraStream& operator=(const CameraStream&) = delete;

  /// Pixels of this picture size that are not above `limit` need not be right. Not while streaming.
  void set_limit(std::span<const std::uint8_t> limit);
  /// Streams into slots of `pool`, which must have frames of format().size for this camera: in place where
  /// format and driver allow it (GREY, rows of the pool's length), else copied or decoded. The pool must stay
  /// until stop(). Throws Error; NoSuchCamera if it was unplugged, or had to be closed by stop().
  void start(FramePool& pool, CameraId camera);
  /// Gives back all slots. The camera stays open.
  void stop() noexcept;

  /// Waits for the next frame, no longer than `longest`.
  [[nodiscard]] StreamStatus next(ReceivedFrame& received, std::chrono::nanoseconds longest) noexcept;

  /// No frame for three periods (after start(): three seconds). Ends with the next frame.
  bool silent() const noexcept { return silent_; }
  const AgreedFormat& format() const noexcept { return format_; }
  const DeviceIdentity& identity() const noexcept { return identity_; }
  bool in_place() const noexcept { return in_place_; }
  /// Buffers that the driver fills; in place, each holds a slot of the pool.
  std::size_t buffers() const noexcept { return buffers_.size(); }
  const std::string& problem() const noexcept { return problem_; }

 private:
  struct Buffer {
    std::byte* mapped = nullptr;
    std::size_t bytes = 0;
    Frame slot;  // in place: where the driver writes
    bool queued = false;
  };
  bool still_there() noexcept;
  bool start_in_place(FramePool& pool);
  void start_mapped();
  void free_buffers() noexcept;
  int queue(std::uint32_t index) noexcept;
  bool requeue() noexcept;
  StreamStatus fail(const char* what, int error) noexcept;
  bool too_old(Timestamp stamped, Timestamp arrived) noexcept;
  StreamStatus dequeue(ReceivedFrame& received, bool trouble) noexcept;
  void receive(Buffer& buffer, std::size_t bytes, ReceivedFrame& received) noexcept;
  FrameFlaw decode(const Buffer& buffer, std::size_t bytes, Frame& frame) noexcept;

  std::string name_;
  DeviceIdentity identity_;
  DeviceNode node_;
  AgreedFormat format_;
  std::chrono::nanoseconds silence_after_{}, too_old_after_{};
  std::chrono::nanoseconds least_latency_{};  // from stamp to arrival, lately
  JpegDecoder jpeg_;
  FramePool* pool_ = nullptr;
  CameraId camera_{};
  std::vector<Buffer> buffers_;
  bool in_place_ = false, streaming_ = false, silent_ = false;
  Timestamp quiet_until_{};  // silent if nothing came by then
  unsigned troubles_ = 0;    // in a row, without a frame
  std::string problem_;
};

}  // namespace glint
