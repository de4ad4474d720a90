// SPDX-License-Identifier: MIT
// Setting format, size and rate, and not taking less than what was asked for.
#include <linux/videodev2.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cmath>
#include <cstdio>
#include <cstring>

#include "gpu/detector.hpp"
#include "host/base/error.hpp"
#include "host/capture/v4l2/camera_formats.hpp"

namespace glint {
namespace {

constexpr double kRateTolerance = 0.01;  // CVT timings of "90 Hz" are 89.7
constexpr double kRateUnit = 10'000.0;   // rates are set as so many frames in so many parts of a second

std::string text_of(FrameSize size) {
  return std::to_string(size.width_px) + "x" + std::to_string(size.height_px);
}

std::string text_of(double rate_hz) {
  char text[32];
  std::snprintf(text, sizeof text, "%.4g Hz", rate_hz);
  return text;
}

bool same_rate(double a, double b) noexcept { return std::abs(a - b) <= kRateTolerance * b; }

v4l2_format current_format(DeviceNode& node) {
  v4l2_format format{};
  format.type = V4L2_BUF_TYPE_VIDEO_CAPTURE;
  const int result = node.ioctl(VIDIOC_G_FMT, &format);
  if (result < 0) throw Error(std::string("its format cannot be read: ") + std::strerror(-result));
  return format;
}

/// The layout that the driver's answer describes; nothing if it is not what was asked for, or cannot be.
std::optional<AgreedFormat> layout_of(const v4l2_pix_format& pix, std::uint32_t fourcc, PixelKind kind,
                                      FrameSize size) {
  const bool progressive = pix.field == V4L2_FIELD_NONE || pix.field == V4L2_FIELD_ANY;
  if (pix.pixelformat != fourcc || pix.width != size.width_px || pix.height != size.height_px || !progressive)
    return std::nullopt;
  AgreedFormat agreed;
  agreed.kind = kind;
  agreed.size = size;
  agreed.buffer_bytes = pix.sizeimage;
  if (kind == PixelKind::Mjpeg) {
    agreed.image_bytes = pix.sizeimage;
    return pix.sizeimage > 0 ? std::optional(agreed) : std::nullopt;
  }
  const std::uint32_t row_bytes = size.width_px * (kind == PixelKind::Yuyv ? 2u : 1u);
  agreed.stride_bytes = pix.bytesperline == 0 ? row_bytes : pix.bytesperline;
  agreed.image_bytes = std::size_t{agreed.stride_bytes} * (size.height_px - 1) + row_bytes;
  if (agreed.stride_bytes < row_bytes || pix.sizeimage < agreed.image_bytes) return std::nullopt;
  return agreed;
}

/// The rate that is set then; 0 if the driver has no say in it.
double set_rate(DeviceNode& node, double rate_hz) {
  v4l2_streamparm parameters{};
  parameters.type = V4L2_BUF_TYPE_VIDEO_CAPTURE;
  if (node.ioctl(VIDIOC_G_PARM, &parameters) < 0) return 0.0;
  v4l2_captureparm& capture = parameters.parm.capture;
  const auto agreed = [&capture] {
    const v4l2_fract& interval = capture.timeperframe;
    return interval.numerator == 0 ? 0.0 : static_cast<double>(interval.denominator) / interval.numerator;
  };
  if (rate_hz <= 0.0 || (capture.capability & V4L2_CAP_TIMEPERFRAME) == 0) return agreed();
  capture.timeperframe = {static_cast<std::uint32_t>(kRateUnit),
                          static_cast<std::uint32_t>(std::lround(rate_hz * kRateUnit))};
  const int result = node.ioctl(VIDIOC_S_PARM, &parameters);
  if (result < 0) {
    throw Error("a rate of " + text_of(rate_hz) + " was refused: " + std::strerror(-result) +
                (result == -EBUSY ? " (is another program using the camera?)" : ""));
  }
  return agreed();
}

std::string wanted_text(const WantedFormat& wanted, FrameSize size) {
  return (wanted.kind ? std::string(name_of(*wanted.kind)) + " " : "") + text_of(size) +
         (wanted.rate_hz > 0.0 ? " at " + text_of(wanted.rate_hz) : "");
}

struct Refusal {
  int error = 0;           // errno
  std::string other_rate;  // what there is instead
};

std::vector<FormatOffer> readable(std::vector<FormatOffer> formats) {
  std::erase_if(formats, [](const FormatOffer& format) { return !format.kind; });
  return formats;
}

/// Asks for one format; nothing if the driver gives something else. Why goes into `refusal`.
std::optional<AgreedFormat> try_format(DeviceNode& node, const FormatOffer& format, FrameSize size,
                                       double rate_hz, Refusal& refusal) {
  v4l2_format request{};
  request.type = V4L2_BUF_TYPE_VIDEO_CAPTURE;
  request.fmt.pix.width = size.width_px;
  request.fmt.pix.height = size.height_px;
  request.fmt.pix.pixelformat = format.fourcc;
  request.fmt.pix.field = V4L2_FIELD_NONE;
  const int result = node.ioctl(VIDIOC_S_FMT, &request);
  if (result < 0) {
    refusal.error = -result;
    return std::nullopt;
  }
  std::optional<AgreedFormat> agreed = layout_of(request.fmt.pix, format.fourcc, *format.kind, size);
  if (!agreed) return std::nullopt;
  agreed->rate_hz = set_rate(node, rate_hz);
  if (rate_hz <= 0.0 || agreed->rate_hz == 0.0 || same_rate(agreed->rate_hz, rate_hz)) return agreed;
  refusal.other_rate = "; the driver would give " + text_of(agreed->rate_hz);
  return std::nullopt;
}

}  // namespace

bool offers(const FormatOffer& format, FrameSize size, double rate_hz) noexcept {
  if (format.sizes.empty()) return true;  // the driver does not say; S_FMT will
  return std::any_of(format.sizes.begin(), format.sizes.end(), [&](const SizeOffer& offer) {
    if (!offer.holds(size)) return false;
    // Rates were listed for the largest of a range of sizes, and smaller ones may be faster.
    if (rate_hz <= 0.0 || !offer.discrete()) return true;
    const RateOffer& rates = offer.rates;
    if (rates.discrete_hz.empty()) {
      return rates.highest_hz <= 0.0 || (rate_hz <= rates.highest_hz * (1.0 + kRateTolerance) &&
                                         rate_hz >= rates.lowest_hz * (1.0 - kRateTolerance));
    }
    return std::any_of(rates.discrete_hz.begin(), rates.discrete_hz.end(),
                       [&](double rate) { return same_rate(rate, rate_hz); });
  });
}

AgreedFormat negotiate(DeviceNode& node, const WantedFormat& wanted) {
  FrameSize size = wanted.size;
  if (size.width_px == 0 || size.height_px == 0) {
    const v4l2_format now = current_format(node);
    size = {now.fmt.pix.width, now.fmt.pix.height};
  }
  if (size.width_px == 0 || size.height_px == 0 ||
      std::uint64_t{size.width_px} * size.height_px > gpu::kMaxPixels)
    throw Error("pictures of " + text_of(size) + " pixels are not possible");
  const std::vector<FormatOffer> formats = list_formats(node);
  Refusal refusal;
  // Some drivers can do more than they list: what they list first, then the rest.
  for (const bool listed : {true, false}) {
    for (const PixelKind kind : kKindsInOrder) {
      if (wanted.kind && *wanted.kind != kind) continue;
      for (const FormatOffer& format : formats) {
        if (format.kind != kind || offers(format, size, wanted.rate_hz) != listed) continue;
        if (const auto agreed = try_format(node, format, size, wanted.rate_hz, refusal)) return *agreed;
      }
    }
  }
  if (refusal.error == EBUSY) {
    throw Error(wanted_text(wanted, size) +
                ": the camera is busy: another program uses it, or (v4l2loopback) nobody feeds it yet");
  }
  throw Error("does not offer " + wanted_text(wanted, size) +
              (refusal.error != 0 ? std::string(" (") + std::strerror(refusal.error) + ")" : "") +
              refusal.other_rate + "; it offers: " + describe(readable(formats)));
}

}  // namespace glint
