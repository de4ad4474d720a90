// SPDX-License-Identifier: MIT
// Owners for FFmpeg's objects, its errors as text, and its log as values. Only av_*.cpp include this.
#pragma once

extern "C" {
#include <libavcodec/avcodec.h>
#include <libavformat/avformat.h>
#include <libavutil/dict.h>
#include <libavutil/frame.h>
#include <libswscale/swscale.h>
}

#include <memory>
#include <string>

namespace glint::av {

struct Deleter {
  void operator()(AVFrame* frame) const noexcept { av_frame_free(&frame); }
  void operator()(AVPacket* packet) const noexcept { av_packet_free(&packet); }
  void operator()(AVCodecContext* context) const noexcept { avcodec_free_context(&context); }
  void operator()(AVFormatContext* context) const noexcept { avformat_close_input(&context); }
  void operator()(SwsContext* context) const noexcept { sws_freeContext(context); }
};

using FramePtr = std::unique_ptr<AVFrame, Deleter>;
using PacketPtr = std::unique_ptr<AVPacket, Deleter>;
using CodecPtr = std::unique_ptr<AVCodecContext, Deleter>;
using FormatPtr = std::unique_ptr<AVFormatContext, Deleter>;
using SwsPtr = std::unique_ptr<SwsContext, Deleter>;

/// Never null: throws std::bad_alloc.
FramePtr make_frame();
PacketPtr make_packet();

/// A decoder that runs in the calling thread, so that its log messages can be told to belong to it. Throws
/// Error if there is none for this codec.
CodecPtr make_decoder(AVCodecID id, const AVCodecParameters* parameters, int strictness);

/// FFmpeg's words for an error code.
std::string error_text(int code);

/// While it lives, errors that FFmpeg logs in this thread are kept here instead of printed. Scopes nest.
class LogScope {
 public:
  LogScope() noexcept;
  ~LogScope();
  LogScope(const LogScope&) = delete;
  LogScope& operator=(const LogScope&) = delete;

  bool had_error() const noexcept { return errors_ > 0; }
  /// The first error, or "".
  const std::string& first() const noexcept { return first_; }
  void clear() noexcept;

 private:
  friend void keep_message(void*, int, const char*, va_list) noexcept;
  LogScope* outer_;
  unsigned errors_ = 0;
  std::string first_;
};

}  // namespace glint::av
