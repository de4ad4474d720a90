// SPDX-License-Identifier: MIT
// Receiving frames: poll, dequeue, judge, convert, queue again.
#include "host/capture/v4l2/camera_stream.hpp"

#include <linux/videodev2.h>
#include <poll.h>

#include <algorithm>
#include <cerrno>
#include <cstring>

#include "host/base/check.hpp"
#include "host/base/error.hpp"
#include "host/capture/v4l2/grey_rows.hpp"
#include "host/capture/v4l2/time_stamp.hpp"

namespace glint {
namespace {

using std::chrono::nanoseconds;

constexpr double kSilentPeriods = 3.0, kOldPeriods = 2.0, kRateIfUnknown_hz = 30.0;
constexpr double kLongestSilence_s = 3600.0;         // whatever rate a driver says it has
constexpr std::chrono::seconds kFirstFrame{3};       // cameras take their time to start
constexpr std::chrono::milliseconds kRetryQueue{5};  // while the driver refuses a buffer
constexpr int kLatencyMemory = 512;                  // frames
// Errors without a frame between them after which a stream is given up.
constexpr unsigned kMostTroubles = 20;

nanoseconds time_of_periods(double periods, double rate_hz) noexcept {
  return nanoseconds(static_cast<std::int64_t>(std::min(periods / rate_hz, kLongestSilence_s) * 1e9));
}

}  // namespace

CameraStream::CameraStream(DeviceCalls& calls, const DeviceRoots& roots, const CameraRequest& request)
    : name_(request.name) {
  std::string where = "camera " + name_;
  try {
    OpenCamera opened = open_camera(calls, roots, request.device);
    identity_ = std::move(opened.identity);
    node_ = std::move(opened.node);
    where += " (" + identity_.node + ")";
    format_ = negotiate(node_, request.format);
    set_controls(node_, request.controls);
  } catch (const NoSuchCamera& error) {
    throw NoSuchCamera(where + ": " + error.what());
  } catch (const Error& error) {
    throw Error(where + ": " + error.what());
  }
  const double agreed_hz = format_.rate_hz > 0.0 ? format_.rate_hz : kRateIfUnknown_hz;
  const double rate_hz = request.pulse_rate_hz > 0.0 ? request.pulse_rate_hz : agreed_hz;
  silence_after_ = time_of_periods(kSilentPeriods, rate_hz);
  too_old_after_ = time_of_periods(kOldPeriods, rate_hz);
  problem_.reserve(256);
}

void CameraStream::set_limit(std::span<const std::uint8_t> limit) {
  if (format_.kind == PixelKind::Mjpeg) jpeg_.set_limit(limit, format_.size);
}

void CameraStream::stop() noexcept {
  if (streaming_) {
    int type = V4L2_BUF_TYPE_VIDEO_CAPTURE;
    // A driver that cannot be told to stop may go on writing into our slots until the node is closed.
    if (node_.ioctl(VIDIOC_STREAMOFF, &type) < 0) node_.close();
  }
  streaming_ = silent_ = false;
  free_buffers();
}

/// Hands a buffer to the driver; 0 or -errno.
int CameraStream::queue(std::uint32_t index) noexcept {
  Buffer& buffer = buffers_[index];
  v4l2_buffer request{};
  request.index = index;
  request.type = V4L2_BUF_TYPE_VIDEO_CAPTURE;
  request.memory = in_place_ ? V4L2_MEMORY_USERPTR : V4L2_MEMORY_MMAP;
  if (in_place_) {
    request.m.userptr = reinterpret_cast<unsigned long>(buffer.slot.pixels().data());
    request.length = static_cast<std::uint32_t>(buffer.slot.pixels().size());
  }
  const int result = std::min(node_.ioctl(VIDIOC_QBUF, &request), 0);
  if (result == 0) buffer.queued = true;
  return result;
}

/// Gives the driver whatever it does not have: a buffer whose queueing failed once is lost for ever unless
/// tried again. False if the device is gone.
bool CameraStream::requeue() noexcept {
  for (std::uint32_t n = 0; n < buffers_.size(); ++n) {
    if (!buffers_[n].queued && queue(n) == -ENODEV) return false;
  }
  return true;
}

StreamStatus CameraStream::fail(const char* what, int error) noexcept {
  if (error == ENODEV) return StreamStatus::Unplugged;
  problem_ = what;
  if (error != 0) (problem_ += ": ") += std::strerror(error);
  return StreamStatus::Broken;
}

StreamStatus CameraStream::next(ReceivedFrame& received, nanoseconds longest) noexcept {
  received.frame = {};
  if (!streaming_) return fail("is not streaming", 0);
  if (!requeue()) return StreamStatus::Unplugged;
  const auto is_queued = [](const Buffer& buffer) { return buffer.queued; };
  const bool all_queued = std::all_of(buffers_.begin(), buffers_.end(), is_queued);
  if (std::none_of(buffers_.begin(), buffers_.end(), is_queued) && ++troubles_ > kMostTroubles)
    return fail("the driver takes no buffers", 0);

  const Timestamp now = node_.calls().now();
  nanoseconds wait = all_queued ? longest : std::min<nanoseconds>(longest, kRetryQueue);
  if (!silent_) wait = std::clamp<nanoseconds>(quiet_until_ - now, nanoseconds{0}, wait);
  const int events = node_.calls().poll(node_.descriptor(), wait);
  if (events < 0) return fail("waiting for frames failed", -events);
  if (events == 0) {
    silent_ = silent_ || now + wait >= quiet_until_;
    return StreamStatus::Nothing;
  }
  return dequeue(received, (events & (POLLERR | POLLHUP | POLLNVAL)) != 0);
}

StreamStatus CameraStream::dequeue(ReceivedFrame& received, bool trouble) noexcept {
  v4l2_buffer filled{};
  filled.type = V4L2_BUF_TYPE_VIDEO_CAPTURE;
  filled.memory = in_place_ ? V4L2_MEMORY_USERPTR : V4L2_MEMORY_MMAP;
  const int result = node_.ioctl(VIDIOC_DQBUF, &filled);
  if (result == -EAGAIN) {
    if (++troubles_ <= kMostTroubles) return StreamStatus::Nothing;
    return fail(
        trouble ? "the driver reports errors and no frames" : "the driver promises frames and has none", 0);
  }
  if (result < 0) return fail("the driver failed", -result);
  if (filled.index >= buffers_.size() || !buffers_[filled.index].queued)
    return fail("the driver gave back a buffer that it did not have", 0);
  Buffer& buffer = buffers_[filled.index];
  buffer.queued = false;

  received.arrived = node_.calls().now();
  const FrameTime time = time_of(filled, received.arrived);
  received.flaw = (filled.flags & V4L2_BUF_FLAG_ERROR) != 0 ? FrameFlaw::Flagged : FrameFlaw::None;
  if (received.flaw == FrameFlaw::None && time.point != StampPoint::HostArrival &&
      too_old(time.stamped, received.arrived))
    received.flaw = FrameFlaw::TooOld;
  receive(buffer, filled.bytesused, received);
  Frame& frame = received.frame;
  frame.camera = camera_;
  frame.sequence = filled.sequence;
  frame.stamped = time.stamped;
  frame.stamp = time.point;
  frame.damaged = received.flaw != FrameFlaw::None;

  if (queue(filled.index) == 0) troubles_ = 0;  // else next() tries again
  silent_ = false;
  quiet_until_ = received.arrived + silence_after_;
  return StreamStatus::Frame;
}

/// Only decoding takes so long that frames queue up because of it. How long a frame is usually under way is
/// what the quickest was, forgotten within some seconds, because a driver's clock may drift away from ours.
bool CameraStream::too_old(Timestamp stamped, Timestamp arrived) noexcept {
  const nanoseconds latency = arrived - stamped;
  if (latency < least_latency_) {
    least_latency_ = latency;
  } else {
    least_latency_ += (latency - least_latency_) / kLatencyMemory;
  }
  return format_.kind == PixelKind::Mjpeg && latency - least_latency_ > too_old_after_;
}

/// Moves the picture, if there is a good one, into received.frame.
void CameraStream::receive(Buffer& buffer, std::size_t bytes, ReceivedFrame& received) noexcept {
  if (received.flaw != FrameFlaw::None) return;
  if (format_.kind != PixelKind::Mjpeg && std::min(bytes, buffer.bytes) < format_.image_bytes) {
    received.flaw = FrameFlaw::Short;
    return;
  }
  std::optional<Frame> slot = pool_->take(camera_);
  if (!slot) {
    received.flaw = FrameFlaw::NoSlot;
  } else if (in_place_) {
    received.frame = std::move(buffer.slot);
    buffer.slot = std::move(*slot);
  } else {
    received.flaw = decode(buffer, std::min(bytes, buffer.bytes), *slot);
    if (received.flaw == FrameFlaw::None) received.frame = std::move(*slot);
  }
}

FrameFlaw CameraStream::decode(const Buffer& buffer, std::size_t bytes, Frame& frame) noexcept {
  const GreyTarget target{frame.pixels().data(), frame.stride_bytes(), format_.size};
  if (format_.kind != PixelKind::Mjpeg) {
    copy_grey_rows(buffer.mapped, format_, target);
    return FrameFlaw::None;
  }
  switch (jpeg_.decode({buffer.mapped, bytes}, target)) {
    case JpegResult::Good:
      return FrameFlaw::None;
    case JpegResult::Truncated:
      return FrameFlaw::TruncatedJpeg;
    case JpegResult::WrongSize:
      return FrameFlaw::WrongSize;
    case JpegResult::Corrupt:
      break;
  }
  return FrameFlaw::CorruptJpeg;
}

bool CameraStream::still_there() noexcept {
  v4l2_capability any{};
  return node_.descriptor() >= 0 && node_.ioctl(VIDIOC_QUERYCAP, &any) != -ENODEV;
}

void CameraStream::start(FramePool& pool, CameraId camera) {
  GLINT_CHECK(!streaming_);
  const FrameSize size = pool.size(camera);
  GLINT_CHECK(size.width_px == format_.size.width_px && size.height_px == format_.size.height_px);
  pool_ = &pool;
  camera_ = camera;
  troubles_ = 0;
  try {
    if (!start_in_place(pool)) start_mapped();
    int type = V4L2_BUF_TYPE_VIDEO_CAPTURE;
    const int result = node_.ioctl(VIDIOC_STREAMON, &type);
    if (result == -ENOSPC) {
      throw Error(
          "the USB bus has no bandwidth left for it: use mjpeg, a lower rate, or another USB port "
          "(glint devices shows who shares a bus)");
    }
    if (result < 0) throw Error(std::string("cannot be started: ") + std::strerror(-result));
  } catch (const Error& error) {
    free_buffers();
    const std::string where = "camera " + name_ + " (" + identity_.node + "): ";
    if (!still_there()) throw NoSuchCamera(where + "was unplugged");
    throw Error(where + error.what());
  }
  streaming_ = true;
  least_latency_ = nanoseconds::max();
  quiet_until_ = node_.calls().now() + std::max<nanoseconds>(kFirstFrame, silence_after_);
}

}  // namespace glint
