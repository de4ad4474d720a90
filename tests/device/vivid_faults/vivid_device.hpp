// SPDX-License-Identifier: MIT
// A capture node of the kernel's vivid driver, and what can be made to go wrong with it.
#pragma once

#include <linux/videodev2.h>

#include <cstdint>
#include <string>
#include <string_view>

namespace glint::device {

/// An open node; closes itself. Errors are thrown as Error and name the node.
class VividDevice {
 public:
  explicit VividDevice(const std::string& path);
  VividDevice(VividDevice&& other) noexcept;
  VividDevice& operator=(VividDevice&& other) noexcept;
  ~VividDevice();

  /// `name` is the driver's. Buttons take any value.
  void set_control(std::string_view name, std::int32_t value);
  /// The HDMI input gets a signal of 1280x800 pixels; nobody may be streaming.
  void set_signal(double rate_hz);
  /// Somebody else has buffers of it, as for streaming.
  bool in_use();

 private:
  int call(unsigned long request, void* argument) noexcept;
  std::uint32_t control_named(std::string_view name);
  std::string path_;
  int fd_ = -1;
};

/// Timings of 1280x800 pixels after VESA's CVT, without reduced blanking.
v4l2_bt_timings cvt_timings(double rate_hz) noexcept;

}  // namespace glint::device
