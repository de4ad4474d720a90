// SPDX-License-Identifier: MIT
// FFmpeg's log callback is one per process: it hands each message to the scope of the thread it came from.
#include "host/capture/av_handles.hpp"

extern "C" {
#include <libavutil/error.h>
#include <libavutil/log.h>
}

#include <array>
#include <cstdarg>
#include <cstdio>
#include <mutex>
#include <new>

#include "host/base/error.hpp"

namespace glint::av {
namespace {

// The callback has no argument of ours that could lead to the scope, hence the thread-local.
thread_local LogScope* innermost_scope = nullptr;

}  // namespace

void keep_message(void*, int level, const char* format, va_list arguments) noexcept {
  LogScope* const scope = innermost_scope;
  if (level > AV_LOG_ERROR || scope == nullptr) return;
  if (scope->errors_++ > 0) return;
  std::array<char, 256> line{};
  std::vsnprintf(line.data(), line.size(), format, arguments);
  scope->first_ = line.data();
  while (!scope->first_.empty() && (scope->first_.back() == '\n' || scope->first_.back() == '.')) {
    scope->first_.pop_back();
  }
}

LogScope::LogScope() noexcept : outer_(innermost_scope) {
  static std::once_flag installed;
  std::call_once(installed, [] { av_log_set_callback(keep_message); });
  innermost_scope = this;
}

LogScope::~LogScope() { innermost_scope = outer_; }

void LogScope::clear() noexcept {
  errors_ = 0;
  first_.clear();
}

FramePtr make_frame() {
  FramePtr frame(av_frame_alloc());
  if (!frame) throw std::bad_alloc();
  return frame;
}

PacketPtr make_packet() {
  PacketPtr packet(av_packet_alloc());
  if (!packet) throw std::bad_alloc();
  return packet;
}

CodecPtr make_decoder(AVCodecID id, const AVCodecParameters* parameters, int strictness) {
  const LogScope log;
  const AVCodec* const codec = avcodec_find_decoder(id);
  if (codec == nullptr) {
    throw Error(std::string("FFmpeg has no decoder for ") + avcodec_get_name(id));
  }
  CodecPtr context(avcodec_alloc_context3(codec));
  if (!context) throw std::bad_alloc();
  context->thread_count = 1;
  context->err_recognition = strictness;
  int status = parameters == nullptr ? 0 : avcodec_parameters_to_context(context.get(), parameters);
  if (status >= 0) status = avcodec_open2(context.get(), codec, nullptr);
  if (status < 0) {
    throw Error(std::string("FFmpeg's decoder for ") + avcodec_get_name(id) +
                " does not start: " + (log.had_error() ? log.first() : error_text(status)));
  }
  return context;
}

std::string error_text(int code) {
  std::array<char, AV_ERROR_MAX_STRING_SIZE> text{};
  av_strerror(code, text.data(), text.size());
  return text.data();
}

}  // namespace glint::av
