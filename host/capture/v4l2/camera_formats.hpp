// SPDX-License-Identifier: MIT
// What pictures a camera offers, and agreeing with its driver on one kind of them.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "host/capture/v4l2/device_calls.hpp"
#include "host/frames/frame_pool.hpp"

namespace glint {

/// How the camera's bytes become grey pixels.
enum class PixelKind : std::uint8_t {
  Grey,   ///< one byte a pixel
  Nv12,   ///< the same, colour behind it is not looked at
  Yuyv,   ///< brightness in every other byte
  Mjpeg,  ///< one JPEG a frame
};

/// Which of them is taken where several would do: the least work first.
inline constexpr std::array kKindsInOrder{PixelKind::Grey, PixelKind::Nv12, PixelKind::Yuyv,
                                          PixelKind::Mjpeg};

/// "grey", "nv12", "yuyv", "mjpeg"
std::string_view name_of(PixelKind kind) noexcept;
std::optional<PixelKind> pixel_kind_named(std::string_view name) noexcept;

struct RateOffer {
  std::vector<double> discrete_hz;  ///< fastest first
  double lowest_hz = 0.0,
         highest_hz = 0.0;  ///< a range, where discrete_hz is empty; 0: the driver does not say
};

/// One size, or all from smallest to largest in steps.
struct SizeOffer {
  FrameSize smallest, largest, step;
  RateOffer rates;  ///< at the largest

  bool discrete() const noexcept {
    return smallest.width_px == largest.width_px && smallest.height_px == largest.height_px;
  }
  bool holds(FrameSize size) const noexcept;
};

struct FormatOffer {
  std::uint32_t fourcc = 0;
  std::string name;               ///< the four characters
  std::string description;        ///< the driver's
  std::optional<PixelKind> kind;  ///< nothing: glint cannot read it
  std::vector<SizeOffer> sizes;   ///< empty: the driver does not say
};

/// Whether size and rate (0: any) are among those that are listed for the format; true where the driver does
/// not say. Drivers may do more than they list.
bool offers(const FormatOffer& format, FrameSize size, double rate_hz) noexcept;

/// Everything the driver lists.
std::vector<FormatOffer> list_formats(DeviceNode& node);
/// "MJPG 1280x800 at 120, 90, 60 Hz; GREY 640x400 at 240 Hz"
std::string describe(const std::vector<FormatOffer>& formats);
std::string describe(const RateOffer& rates);

struct WantedFormat {
  std::optional<PixelKind> kind;  ///< nothing: the first that fits of grey, nv12, yuyv, mjpeg
  FrameSize size;                 ///< 0x0: what the driver is set to
  double rate_hz = 0.0;           ///< 0: what the driver is set to
};

/// What the driver agreed to.
struct AgreedFormat {
  PixelKind kind = PixelKind::Grey;
  FrameSize size;
  std::uint32_t stride_bytes = 0;  ///< of the driver's rows; 0 for MJPEG
  std::size_t image_bytes = 0;     ///< the least that a whole raw frame has; the most that a JPEG has
  std::size_t buffer_bytes = 0;    ///< what the driver wants a buffer to hold
  double rate_hz = 0.0;            ///< 0: the driver has no say in it
};

/// Sets format, size and rate, exactly (the rate within 1 %). Throws Error that says what is offered instead.
AgreedFormat negotiate(DeviceNode& node, const WantedFormat& wanted);

/// Text out of a driver's fixed field, whatever is in it: ends at the first NUL, control characters become
/// '?'.
std::string driver_text(const void* field, std::size_t bytes);

}  // namespace glint
