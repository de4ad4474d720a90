// SPDX-License-Identifier: MIT
// encode_png on libavcodec.
#include <cstring>
#include <new>
#include <string>

#include "host/base/check.hpp"
#include "host/base/error.hpp"
#include "host/capture/av_handles.hpp"
#include "host/capture/png_encoder.hpp"

namespace glint {
namespace {

constexpr int kCompression = 3;  // of 9: pictures for the eye; more takes longer and saves little

void require(int status, const av::LogScope& log) {
  if (status >= 0) return;
  throw Error("PNG encoding failed: " + (log.had_error() ? log.first() : av::error_text(status)));
}

}  // namespace

std::vector<std::uint8_t> encode_png(std::uint32_t width_px, std::uint32_t height_px, unsigned channels,
                                     std::span<const std::uint8_t> pixels) {
  GLINT_CHECK(channels == 1 || channels == 3);
  GLINT_CHECK(pixels.size() == std::size_t{width_px} * height_px * channels);
  const av::LogScope log;
  const AVCodec* const codec = avcodec_find_encoder(AV_CODEC_ID_PNG);
  if (codec == nullptr) throw Error("FFmpeg was built without a PNG encoder");
  const av::CodecPtr encoder(avcodec_alloc_context3(codec));
  if (!encoder) throw std::bad_alloc();
  encoder->width = static_cast<int>(width_px);
  encoder->height = static_cast<int>(height_px);
  encoder->pix_fmt = channels == 1 ? AV_PIX_FMT_GRAY8 : AV_PIX_FMT_RGB24;
  encoder->time_base = {1, 1};
  encoder->thread_count = 1;
  encoder->compression_level = kCompression;
  require(avcodec_open2(encoder.get(), codec, nullptr), log);

  const av::FramePtr frame = av::make_frame();
  frame->format = encoder->pix_fmt;
  frame->width = encoder->width;
  frame->height = encoder->height;
  require(av_frame_get_buffer(frame.get(), 0), log);
  const std::size_t row_bytes = std::size_t{width_px} * channels;
  for (std::size_t y = 0; y < height_px; ++y) {
    std::memcpy(frame->data[0] + static_cast<std::ptrdiff_t>(y) * frame->linesize[0],
                pixels.data() + y * row_bytes, row_bytes);
  }
  const av::PacketPtr packet = av::make_packet();
  require(avcodec_send_frame(encoder.get(), frame.get()), log);
  require(avcodec_receive_packet(encoder.get(), packet.get()), log);
  return {packet->data, packet->data + packet->size};
}

}  // namespace glint
