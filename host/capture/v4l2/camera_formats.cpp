// SPDX-License-Identifier: MIT
// Enumeration of formats, sizes and rates.
#include "host/capture/v4l2/camera_formats.hpp"

#include <linux/videodev2.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <cstring>

namespace glint {
namespace {

// A driver that never says "that was all" must not keep us for ever.
constexpr std::uint32_t kMostFormats = 64, kMostSizes = 128, kMostRates = 128;

struct Kind {
  PixelKind kind;
  std::string_view name;
  std::uint32_t fourcc;
};
constexpr std::array<Kind, 5> kKinds{{{PixelKind::Grey, "grey", V4L2_PIX_FMT_GREY},
                                      {PixelKind::Nv12, "nv12", V4L2_PIX_FMT_NV12},
                                      {PixelKind::Yuyv, "yuyv", V4L2_PIX_FMT_YUYV},
                                      {PixelKind::Mjpeg, "mjpeg", V4L2_PIX_FMT_MJPEG},
                                      {PixelKind::Mjpeg, "mjpeg", V4L2_PIX_FMT_JPEG}}};

double rate_of(const v4l2_fract& interval) noexcept {
  if (interval.numerator == 0 || interval.denominator == 0) return 0.0;
  return static_cast<double>(interval.denominator) / static_cast<double>(interval.numerator);
}

RateOffer list_rates(DeviceNode& node, std::uint32_t fourcc, FrameSize size) {
  RateOffer offer;
  for (std::uint32_t n = 0; n < kMostRates; ++n) {
    v4l2_frmivalenum entry{};
    entry.index = n;
    entry.pixel_format = fourcc;
    entry.width = size.width_px;
    entry.height = size.height_px;
    if (node.ioctl(VIDIOC_ENUM_FRAMEINTERVALS, &entry) < 0) break;
    if (entry.type != V4L2_FRMIVAL_TYPE_DISCRETE) {
      offer.highest_hz = rate_of(entry.stepwise.min);  // the shortest interval
      offer.lowest_hz = rate_of(entry.stepwise.max);
      break;
    }
    const double rate = rate_of(entry.discrete);
    if (rate > 0.0) offer.discrete_hz.push_back(rate);
  }
  std::sort(offer.discrete_hz.begin(), offer.discrete_hz.end(), std::greater<>());
  return offer;
}

std::vector<SizeOffer> list_sizes(DeviceNode& node, std::uint32_t fourcc) {
  std::vector<SizeOffer> sizes;
  for (std::uint32_t n = 0; n < kMostSizes; ++n) {
    v4l2_frmsizeenum entry{};
    entry.index = n;
    entry.pixel_format = fourcc;
    if (node.ioctl(VIDIOC_ENUM_FRAMESIZES, &entry) < 0) break;
    SizeOffer size;
    if (entry.type == V4L2_FRMSIZE_TYPE_DISCRETE) {
      size.smallest = size.largest = {entry.discrete.width, entry.discrete.height};
    } else {
      size.smallest = {entry.stepwise.min_width, entry.stepwise.min_height};
      size.largest = {entry.stepwise.max_width, entry.stepwise.max_height};
      size.step = {std::max(1u, entry.stepwise.step_width), std::max(1u, entry.stepwise.step_height)};
    }
    size.rates = list_rates(node, fourcc, size.largest);
    sizes.push_back(std::move(size));
    if (entry.type != V4L2_FRMSIZE_TYPE_DISCRETE) break;
  }
  return sizes;
}

std::string size_text(FrameSize size) {
  return std::to_string(size.width_px) + "x" + std::to_string(size.height_px);
}

std::string rate_text(double rate_hz) {
  char text[32];
  std::snprintf(text, sizeof text, "%.4g", rate_hz);
  return text;
}

}  // namespace

std::string_view name_of(PixelKind kind) noexcept {
  for (const Kind& known : kKinds) {
    if (known.kind == kind) return known.name;
  }
  return "";
}

std::optional<PixelKind> pixel_kind_named(std::string_view name) noexcept {
  for (const Kind& known : kKinds) {
    if (known.name == name) return known.kind;
  }
  return std::nullopt;
}

bool SizeOffer::holds(FrameSize size) const noexcept {
  const auto fits = [](std::uint32_t value, std::uint32_t least, std::uint32_t most, std::uint32_t by) {
    return value >= least && value <= most && (by == 0 || (value - least) % by == 0);
  };
  return fits(size.width_px, smallest.width_px, largest.width_px, step.width_px) &&
         fits(size.height_px, smallest.height_px, largest.height_px, step.height_px);
}

std::string driver_text(const void* field, std::size_t bytes) {
  std::string text(static_cast<const char*>(field), bytes);
  text.resize(std::strlen(text.c_str()));
  for (char& c : text) {
    const auto byte = static_cast<unsigned char>(c);
    if (byte < 0x20 || byte >= 0x7f) c = '?';
  }
  return text;
}

std::vector<FormatOffer> list_formats(DeviceNode& node) {
  std::vector<FormatOffer> formats;
  for (std::uint32_t n = 0; n < kMostFormats; ++n) {
    v4l2_fmtdesc entry{};
    entry.index = n;
    entry.type = V4L2_BUF_TYPE_VIDEO_CAPTURE;
    if (node.ioctl(VIDIOC_ENUM_FMT, &entry) < 0) break;
    FormatOffer format;
    format.fourcc = entry.pixelformat;
    format.name = driver_text(&entry.pixelformat, 4);
    format.description = driver_text(entry.description, sizeof entry.description);
    for (const Kind& known : kKinds) {
      if (known.fourcc == entry.pixelformat) format.kind = known.kind;
    }
    format.sizes = list_sizes(node, entry.pixelformat);
    formats.push_back(std::move(format));
  }
  return formats;
}

std::string describe(const RateOffer& rates) {
  std::string text;
  for (const double rate : rates.discrete_hz) text += (text.empty() ? "" : ", ") + rate_text(rate);
  if (text.empty() && rates.highest_hz > 0.0)
    text = rate_text(rates.lowest_hz) + " to " + rate_text(rates.highest_hz);
  return text.empty() ? text : text + " Hz";
}

std::string describe(const std::vector<FormatOffer>& formats) {
  std::string text;
  for (const FormatOffer& format : formats) {
    if (format.sizes.empty()) text += (text.empty() ? "" : "; ") + format.name;
    for (const SizeOffer& size : format.sizes) {
      text += (text.empty() ? "" : "; ") + format.name + " " + size_text(size.smallest);
      if (!size.discrete()) text += " to " + size_text(size.largest);
      const std::string rates = describe(size.rates);
      if (!rates.empty()) text += " at " + rates;
    }
  }
  return text.empty() ? "nothing that glint can read" : text;
}

}  // namespace glint
