// SPDX-License-Identifier: MIT
// ioctls of the driver, and VESA's coordinated video timings 1.1, which it demands of a signal.
#include "tests/device/vivid_faults/vivid_device.hpp"

#include <fcntl.h>
#include <sys/ioctl.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cmath>
#include <cstring>
#include <utility>

#include "host/base/error.hpp"

namespace glint::device {

VividDevice::VividDevice(const std::string& path)
    : path_(path), fd_(open(path.c_str(), O_RDWR | O_NONBLOCK | O_CLOEXEC)) {
  if (fd_ < 0) throw Error(path_ + ": cannot be opened: " + std::strerror(errno));
}

VividDevice::VividDevice(VividDevice&& other) noexcept
    : path_(std::move(other.path_)), fd_(std::exchange(other.fd_, -1)) {}

VividDevice& VividDevice::operator=(VividDevice&& other) noexcept {
  std::swap(path_, other.path_);
  std::swap(fd_, other.fd_);
  return *this;
}

VividDevice::~VividDevice() {
  if (fd_ >= 0) close(fd_);
}

int VividDevice::call(unsigned long request, void* argument) noexcept {
  int result = 0;
  do {
    result = ioctl(fd_, request, argument);
  } while (result < 0 && errno == EINTR);
  return result;
}

std::uint32_t VividDevice::control_named(std::string_view name) {
  v4l2_queryctrl control{};
  control.id = V4L2_CTRL_FLAG_NEXT_CTRL;
  while (call(VIDIOC_QUERYCTRL, &control) == 0) {
    if (name == reinterpret_cast<const char*>(control.name)) return control.id;
    control.id |= V4L2_CTRL_FLAG_NEXT_CTRL;
  }
  throw Error(path_ + ": has no control \"" + std::string(name) + "\"; is it vivid's?");
}

void VividDevice::set_control(std::string_view name, std::int32_t value) {
  v4l2_control control{control_named(name), value};
  if (call(VIDIOC_S_CTRL, &control) != 0)
    throw Error(path_ + ": \"" + std::string(name) + "\" is refused: " + std::strerror(errno));
}

void VividDevice::set_signal(double rate_hz) {
  v4l2_dv_timings timings{};
  timings.type = V4L2_DV_BT_656_1120;
  timings.bt = cvt_timings(rate_hz);
  if (call(VIDIOC_S_DV_TIMINGS, &timings) != 0)
    throw Error(path_ + ": refuses a signal of 1280x800 at this rate: " + std::strerror(errno));
}

bool VividDevice::in_use() {
  v4l2_requestbuffers none{};
  none.type = V4L2_BUF_TYPE_VIDEO_CAPTURE;
  none.memory = V4L2_MEMORY_MMAP;
  return call(VIDIOC_REQBUFS, &none) != 0 && errno == EBUSY;
}

v4l2_bt_timings cvt_timings(double rate_hz) noexcept {
  constexpr std::uint32_t kWidth_px = 1280, kHeight_px = 800;
  constexpr double kVerticalBlank_us = 550.0, kClockStep_hz = 250e3;
  constexpr std::uint32_t kFrontPorch = 3, kSync = 6;  // lines; this sync says 16:10
  v4l2_bt_timings bt{};
  bt.width = kWidth_px;
  bt.height = kHeight_px;
  const double line_us = (1e6 / rate_hz - kVerticalBlank_us) / (kHeight_px + kFrontPorch);
  bt.vfrontporch = kFrontPorch;
  bt.vsync = kSync;
  bt.vbackporch = static_cast<std::uint32_t>(kVerticalBlank_us / line_us) + 1 - kSync;
  const double blank_share = std::max(0.3 - 3e-3 * line_us, 0.2);
  const std::uint32_t blank =
      static_cast<std::uint32_t>(kWidth_px * blank_share / (1.0 - blank_share) / 16.0) * 16;
  const std::uint32_t total = kWidth_px + blank;
  bt.hsync = static_cast<std::uint32_t>(total * 0.08 / 8.0) * 8;
  bt.hbackporch = blank / 2;
  bt.hfrontporch = blank - bt.hbackporch - bt.hsync;
  bt.pixelclock =
      static_cast<std::uint64_t>(std::floor(total / line_us * 1e6 / kClockStep_hz) * kClockStep_hz);
  bt.polarities = V4L2_DV_VSYNC_POS_POL;
  bt.standards = V4L2_DV_BT_STD_CVT;
  return bt;
}

}  // namespace glint::device
