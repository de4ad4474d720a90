// SPDX-License-Identifier: MIT
// Conversion of FFmpeg's pixel formats to grey.
#include "host/capture/av_grey.hpp"

extern "C" {
#include <libavutil/pixdesc.h>
}

#include <algorithm>
#include <cstring>

namespace glint::av {
namespace {

// ITU-R BT.601 luma in 1/256; they add up to 256, so that r = g = b stays what it is.
constexpr unsigned kRed = 77, kGreen = 150, kBlue = 29;

std::uint8_t luma(unsigned red, unsigned green, unsigned blue) noexcept {
  return static_cast<std::uint8_t>((red * kRed + green * kGreen + blue * kBlue + 128u) >> 8u);
}

/// Grey, or YUV with the luma in whole bytes: the first component can be read as it lies.
bool has_plain_luma(const AVPixFmtDescriptor& format) noexcept {
  constexpr std::uint64_t kNotPlain = AV_PIX_FMT_FLAG_RGB | AV_PIX_FMT_FLAG_PAL | AV_PIX_FMT_FLAG_BITSTREAM |
                                      AV_PIX_FMT_FLAG_HWACCEL | AV_PIX_FMT_FLAG_BAYER | AV_PIX_FMT_FLAG_FLOAT;
  return format.nb_components > 0 && (format.flags & kNotPlain) == 0 && format.comp[0].depth >= 8 &&
         format.comp[0].depth <= 16;
}

bool is_video_range(const AVFrame& frame, const AVPixFmtDescriptor& format) noexcept {
  if (format.nb_components < 3) return false;  // grey is taken as it is
  switch (frame.format) {
    case AV_PIX_FMT_YUVJ411P:
    case AV_PIX_FMT_YUVJ420P:
    case AV_PIX_FMT_YUVJ422P:
    case AV_PIX_FMT_YUVJ440P:
    case AV_PIX_FMT_YUVJ444P:
      return false;
    default:
      return frame.color_range != AVCOL_RANGE_JPEG;
  }
}

/// Levels black..white to 0..255, rounded; video range puts black at 16/256 and white at 235/256.
struct Levels {
  unsigned black, white;
  std::uint8_t operator()(unsigned value) const noexcept {
    const unsigned above = std::clamp(value, black, white) - black, span = white - black;
    return static_cast<std::uint8_t>((above * 255u + span / 2u) / span);
  }
};

void convert_luma(const AVFrame& frame, const AVPixFmtDescriptor& format, const GreyTarget& target) {
  const AVComponentDescriptor& component = format.comp[0];
  const auto depth = static_cast<unsigned>(component.depth);
  const bool video_range = is_video_range(frame, format);
  const Levels levels =
      video_range ? Levels{16u << (depth - 8u), 235u << (depth - 8u)} : Levels{0u, (1u << depth) - 1u};
  std::array<std::uint8_t, 256> table{};
  for (unsigned value = 0; value < 256u; ++value) table[value] = depth == 8 ? levels(value) : std::uint8_t{0};
  const std::size_t width_px = target.size.width_px;
  const auto step = static_cast<std::size_t>(component.step);
  const bool big_endian = (format.flags & AV_PIX_FMT_FLAG_BE) != 0;
  for (std::uint32_t y = 0; y < target.size.height_px; ++y) {
    const std::uint8_t* const in =
        frame.data[component.plane] + std::ptrdiff_t{y} * frame.linesize[component.plane] + component.offset;
    std::uint8_t* const out = target.pixels + y * target.stride_bytes;
    if (depth == 8 && step == 1 && !video_range) {
      std::memcpy(out, in, width_px);
    } else if (depth == 8) {
      for (std::size_t x = 0; x < width_px; ++x) out[x] = table[in[x * step]];
    } else {
      for (std::size_t x = 0; x < width_px; ++x) {
        const unsigned first = in[x * step], second = in[x * step + 1];
        const unsigned word = big_endian ? first << 8u | second : second << 8u | first;
        out[x] = levels(word >> static_cast<unsigned>(component.shift));
      }
    }
  }
}

void convert_palette(const AVFrame& frame, const GreyTarget& target) {
  std::array<std::uint8_t, 256> grey{};
  for (std::size_t entry = 0; entry < grey.size(); ++entry) {
    std::uint32_t argb = 0;
    std::memcpy(&argb, frame.data[1] + 4 * entry, sizeof argb);
    grey[entry] = luma(argb >> 16u & 255u, argb >> 8u & 255u, argb & 255u);
  }
  for (std::uint32_t y = 0; y < target.size.height_px; ++y) {
    const std::uint8_t* const in = frame.data[0] + std::ptrdiff_t{y} * frame.linesize[0];
    std::uint8_t* const out = target.pixels + y * target.stride_bytes;
    for (std::size_t x = 0; x < target.size.width_px; ++x) out[x] = grey[in[x]];
  }
}

}  // namespace

bool GreyConverter::convert(const AVFrame& frame, const GreyTarget& target) {
  const AVPixFmtDescriptor* const format = av_pix_fmt_desc_get(static_cast<AVPixelFormat>(frame.format));
  if (format == nullptr) return false;
  if (frame.format == AV_PIX_FMT_PAL8) {
    convert_palette(frame, target);
  } else if (has_plain_luma(*format)) {
    convert_luma(frame, *format, target);
  } else {
    return convert_colour(frame, target);
  }
  return true;
}

/// swscale unpacks to RGB, which is exact for 8-bit colour; its own way to grey goes through video range and
/// is not.
bool GreyConverter::convert_colour(const AVFrame& frame, const GreyTarget& target) {
  const LogScope log;
  if (rgb_source_format_ != frame.format || rgb_width_ != frame.width || rgb_height_ != frame.height) {
    to_rgb_.reset(sws_getContext(frame.width, frame.height, static_cast<AVPixelFormat>(frame.format),
                                 frame.width, frame.height, AV_PIX_FMT_RGB24, SWS_POINT | SWS_ACCURATE_RND,
                                 nullptr, nullptr, nullptr));
    rgb_source_format_ = frame.format;
    rgb_width_ = frame.width;
    rgb_height_ = frame.height;
  }
  if (!to_rgb_) return false;
  const std::size_t stride_bytes = (std::size_t{target.size.width_px} * 3 + 63) / 64 * 64;
  rgb_.resize(stride_bytes * target.size.height_px);
  std::uint8_t* const planes[] = {rgb_.data()};
  const int strides[] = {static_cast<int>(stride_bytes)};
  if (sws_scale(to_rgb_.get(), frame.data, frame.linesize, 0, frame.height, planes, strides) !=
      frame.height) {
    return false;
  }
  for (std::uint32_t y = 0; y < target.size.height_px; ++y) {
    const std::uint8_t* in = rgb_.data() + y * stride_bytes;
    std::uint8_t* const out = target.pixels + y * target.stride_bytes;
    for (std::size_t x = 0; x < target.size.width_px; ++x, in += 3) out[x] = luma(in[0], in[1], in[2]);
  }
  return true;
}

bool is_deep(const AVFrame& frame) noexcept {
  const AVPixFmtDescriptor* const format = av_pix_fmt_desc_get(static_cast<AVPixelFormat>(frame.format));
  return format != nullptr && format->nb_components > 0 && format->comp[0].depth > 8;
}

}  // namespace glint::av
