// SPDX-License-Identifier: MIT
// Getting buffers from a driver, and letting go of them.
#include <linux/videodev2.h>

#include <cerrno>
#include <cstring>
#include <utility>

#include "host/base/error.hpp"
#include "host/capture/v4l2/camera_stream.hpp"

namespace glint {
namespace {

// Six ride out 60 ms at 90 Hz in which this thread does not run.
constexpr std::uint32_t kBuffers = 6, kFewestBuffers = 2;
constexpr std::uint32_t kMostBuffers = 32;  // VIDEO_MAX_FRAME

/// How many the driver gives, or -errno.
int request_buffers(DeviceNode& node, std::uint32_t memory, std::uint32_t count) noexcept {
  v4l2_requestbuffers request{};
  request.count = count;
  request.type = V4L2_BUF_TYPE_VIDEO_CAPTURE;
  request.memory = memory;
  const int result = node.ioctl(VIDIOC_REQBUFS, &request);
  return result < 0 ? result : static_cast<int>(std::min(request.count, kMostBuffers));
}

}  // namespace

/// Lets the driver write into slots of the pool. False if format or driver do not allow it.
bool CameraStream::start_in_place(FramePool& pool) {
  if (format_.kind != PixelKind::Grey) return false;
  {
    std::optional<Frame> probe = pool.take(camera_);
    if (!probe || probe->stride_bytes() != format_.stride_bytes ||
        probe->pixels().size() < format_.buffer_bytes)
      return false;
  }
  const int count = request_buffers(node_, V4L2_MEMORY_USERPTR, kBuffers);
  if (count < static_cast<int>(kFewestBuffers)) {
    if (count >= 0) (void)request_buffers(node_, V4L2_MEMORY_USERPTR, 0);
    return false;
  }
  in_place_ = true;
  buffers_ = std::vector<Buffer>(static_cast<std::size_t>(count));
  bool any = false;
  for (std::uint32_t n = 0; n < buffers_.size(); ++n) {
    std::optional<Frame> slot = pool.take(camera_);
    if (!slot) break;
    buffers_[n].bytes = slot->pixels().size();
    buffers_[n].slot = std::move(*slot);
    any |= queue(n) == 0;
  }
  if (any && buffers_.back().bytes > 0) return true;
  free_buffers();
  return false;
}

void CameraStream::start_mapped() {
  const int count = request_buffers(node_, V4L2_MEMORY_MMAP, kBuffers);
  if (count < 0) throw Error(std::string("gives no buffers: ") + std::strerror(-count));
  buffers_ = std::vector<Buffer>(static_cast<std::size_t>(count));
  if (buffers_.size() < kFewestBuffers)
    throw Error("gives " + std::to_string(buffers_.size()) + " buffers; at least 2 are needed");
  bool any = false;
  for (std::uint32_t n = 0; n < buffers_.size(); ++n) {
    v4l2_buffer info{};
    info.index = n;
    info.type = V4L2_BUF_TYPE_VIDEO_CAPTURE;
    info.memory = V4L2_MEMORY_MMAP;
    const int result = node_.ioctl(VIDIOC_QUERYBUF, &info);
    if (result < 0) throw Error(std::string("does not describe its buffers: ") + std::strerror(-result));
    if (format_.kind != PixelKind::Mjpeg && info.length < format_.image_bytes) {
      throw Error("has buffers of " + std::to_string(info.length) + " bytes for pictures of " +
                  std::to_string(format_.image_bytes));
    }
    buffers_[n].mapped = node_.calls().map(node_.descriptor(), info.length, info.m.offset);
    if (buffers_[n].mapped == nullptr) throw Error("its buffers cannot be mapped into memory");
    buffers_[n].bytes = info.length;
    any |= queue(n) == 0;
  }
  if (!any) throw Error("takes no buffers");
}

/// After the driver has stopped writing.
void CameraStream::free_buffers() noexcept {
  for (Buffer& buffer : buffers_) {
    if (buffer.mapped != nullptr) node_.calls().unmap(buffer.mapped, buffer.bytes);
  }
  // The slots go back to the pool last: asking for no buffers makes the driver forget them.
  if (!buffers_.empty() && node_.descriptor() >= 0)
    (void)request_buffers(node_, in_place_ ? V4L2_MEMORY_USERPTR : V4L2_MEMORY_MMAP, 0);
  buffers_.clear();
  in_place_ = false;
}

}  // namespace glint
