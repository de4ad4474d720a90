// SPDX-License-Identifier: MIT
// open, S_FMT, S_PARM, REQBUFS, mmap, QBUF, STREAMON.
#include "tests/device/v4l2_capture/capture_device.hpp"

#include <fcntl.h>
#include <linux/videodev2.h>
#include <sys/ioctl.h>
#include <sys/mman.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <utility>

#include "host/base/error.hpp"

namespace glint::device {
namespace {

[[noreturn]] void fail(const std::string& path, const char* call) {
  throw Error(path + ": " + call + ": " + std::strerror(errno));
}

v4l2_buffer mapped_buffer(std::uint32_t index) {
  v4l2_buffer buffer{};
  buffer.type = V4L2_BUF_TYPE_VIDEO_CAPTURE;
  buffer.memory = V4L2_MEMORY_MMAP;
  buffer.index = index;
  return buffer;
}

}  // namespace

CaptureDevice::CaptureDevice(const std::string& path, const CaptureFormat& wanted, std::uint32_t buffers)
    : fd_(open(path.c_str(), O_RDWR | O_NONBLOCK | O_CLOEXEC)) {
  if (fd_ < 0) fail(path, "open");
  try {
    v4l2_format format{};
    format.type = V4L2_BUF_TYPE_VIDEO_CAPTURE;
    format.fmt.pix.pixelformat = wanted.fourcc;
    format.fmt.pix.width = wanted.width_px;
    format.fmt.pix.height = wanted.height_px;
    if (ioctl(fd_, VIDIOC_S_FMT, &format) != 0) fail(path, "VIDIOC_S_FMT");
    if (format.fmt.pix.pixelformat != wanted.fourcc || format.fmt.pix.width != wanted.width_px ||
        format.fmt.pix.height != wanted.height_px)
      throw Error(path + ": has not the format asked for");
    if (wanted.rate_hz != 0) {
      v4l2_streamparm rate{};
      rate.type = V4L2_BUF_TYPE_VIDEO_CAPTURE;
      rate.parm.capture.timeperframe = {1, wanted.rate_hz};
      if (ioctl(fd_, VIDIOC_S_PARM, &rate) != 0) fail(path, "VIDIOC_S_PARM");
    }
    v4l2_requestbuffers request{};
    request.count = buffers;
    request.type = V4L2_BUF_TYPE_VIDEO_CAPTURE;
    request.memory = V4L2_MEMORY_MMAP;
    if (ioctl(fd_, VIDIOC_REQBUFS, &request) != 0) fail(path, "VIDIOC_REQBUFS");
    for (std::uint32_t i = 0; i < request.count; ++i) {
      v4l2_buffer buffer = mapped_buffer(i);
      if (ioctl(fd_, VIDIOC_QUERYBUF, &buffer) != 0) fail(path, "VIDIOC_QUERYBUF");
      void* memory = mmap(nullptr, buffer.length, PROT_READ | PROT_WRITE, MAP_SHARED, fd_, buffer.m.offset);
      if (memory == MAP_FAILED) fail(path, "mmap");
      buffers_.emplace_back(static_cast<std::uint8_t*>(memory), buffer.length);
      if (ioctl(fd_, VIDIOC_QBUF, &buffer) != 0) fail(path, "VIDIOC_QBUF");
    }
    int type = V4L2_BUF_TYPE_VIDEO_CAPTURE;
    if (ioctl(fd_, VIDIOC_STREAMON, &type) != 0) fail(path, "VIDIOC_STREAMON");
  } catch (...) {
    close_all();
    throw;
  }
}

CaptureDevice::CaptureDevice(CaptureDevice&& other) noexcept
    : fd_(std::exchange(other.fd_, -1)), problem_(other.problem_), buffers_(std::move(other.buffers_)) {}

CaptureDevice::~CaptureDevice() { close_all(); }

void CaptureDevice::close_all() noexcept {
  if (fd_ < 0) return;
  int type = V4L2_BUF_TYPE_VIDEO_CAPTURE;
  ioctl(fd_, VIDIOC_STREAMOFF, &type);
  for (const std::span<std::uint8_t> buffer : buffers_) munmap(buffer.data(), buffer.size());
  close(fd_);
  fd_ = -1;
}

std::optional<CapturedBuffer> CaptureDevice::take() noexcept {
  v4l2_buffer buffer = mapped_buffer(0);
  problem_ = 0;
  if (ioctl(fd_, VIDIOC_DQBUF, &buffer) != 0) {
    if (errno != EAGAIN) problem_ = errno;
    return std::nullopt;
  }
  CapturedBuffer captured;
  captured.index = buffer.index;
  captured.sequence = buffer.sequence;
  captured.flags = buffer.flags;
  captured.stamp_us = std::int64_t{buffer.timestamp.tv_sec} * 1000000 + buffer.timestamp.tv_usec;
  captured.data = buffers_[buffer.index].first(buffer.bytesused);
  return captured;
}

bool CaptureDevice::give_back(const CapturedBuffer& captured) noexcept {
  v4l2_buffer buffer = mapped_buffer(captured.index);
  return ioctl(fd_, VIDIOC_QBUF, &buffer) == 0;
}

}  // namespace glint::device
