// SPDX-License-Identifier: MIT
// VideoDecoder on libavformat and libavcodec.
#include <chrono>
#include <cmath>
#include <new>
#include <set>

#include "host/base/error.hpp"
#include "host/capture/av_grey.hpp"
#include "host/capture/av_handles.hpp"
#include "host/capture/video_decoder.hpp"

namespace glint {
namespace {

using Clock = std::chrono::steady_clock;

/// What FFmpeg asks while it waits for the network: whether to give up.
struct Patience {
  std::stop_token stop;
  Clock::time_point deadline = Clock::time_point::max();
  bool timed_out() const noexcept { return Clock::now() > deadline; }
  static int is_over(void* self) noexcept {
    const auto* const patience = static_cast<const Patience*>(self);
    return patience->stop.stop_requested() || patience->timed_out() ? 1 : 0;
  }
};

/// Options that only some protocols know; those that are left over are none of our concern.
class OptionList {
 public:
  OptionList() = default;
  ~OptionList() { av_dict_free(&list_); }
  OptionList(const OptionList&) = delete;
  OptionList& operator=(const OptionList&) = delete;
  void set(const char* name, const char* value) { av_dict_set(&list_, name, value, 0); }
  AVDictionary** get() noexcept { return &list_; }

 private:
  AVDictionary* list_ = nullptr;
};

/// Codecs whose frames stand alone. There a fault concerns one frame, and the strict decoder finds it; for
/// the others strictness would throw away pictures over trifles.
bool stands_alone(AVCodecID codec) noexcept {
  return codec == AV_CODEC_ID_MJPEG || codec == AV_CODEC_ID_PNG || codec == AV_CODEC_ID_FFV1;
}

}  // namespace

struct VideoDecoder::Impl {
  std::string shown;  // the address for messages
  Patience patience;  // used by `format`: must outlive it
  av::FormatPtr format;
  av::CodecPtr decoder;
  av::PacketPtr packet = av::make_packet();
  av::FramePtr frame = av::make_frame();
  av::GreyConverter converter;
  std::string problem;
  int stream = -1;
  bool draining = false, first_pending = false;
  FrameSize size;

  void open(const std::string& address, const VideoDecoderOptions& options);
  bool video_is_known() const noexcept;
  Step decode_next();
  [[noreturn]] void fail(const std::string& what) const { throw Error(shown + ": " + what); }
  [[noreturn]] void fail_open(int status, const std::string& logged,
                              const VideoDecoderOptions& options) const;
};

void VideoDecoder::Impl::fail_open(int status, const std::string& logged,
                                   const VideoDecoderOptions& options) const {
  if (patience.stop.stop_requested()) fail("opening was stopped");
  if (patience.timed_out()) {
    const std::string seconds = std::to_string(options.open_timeout_s);
    fail("no image within " + seconds.substr(0, seconds.find('.') + 2) +
         " s; check the address, and that the camera is on, reachable and streams");
  }
  std::string why = status == 0 ? "" : av::error_text(status);
  if (!logged.empty()) why += (why.empty() ? "" : ", ") + logged;
  fail("cannot be opened: " + why +
       (options.live ? "; check the address, and that the camera is on and reachable" : ""));
}

bool VideoDecoder::Impl::video_is_known() const noexcept {
  for (unsigned n = 0; n < format->nb_streams; ++n) {
    const AVCodecParameters& parameters = *format->streams[n]->codecpar;
    if (parameters.codec_type == AVMEDIA_TYPE_VIDEO && parameters.codec_id != AV_CODEC_ID_NONE) return true;
  }
  return false;
}

void VideoDecoder::Impl::open(const std::string& address, const VideoDecoderOptions& options) {
  shown = without_password(address);
  patience.stop = options.stop;
  if (options.open_timeout_s > 0.0) {
    patience.deadline = Clock::now() + std::chrono::duration_cast<Clock::duration>(
                                           std::chrono::duration<double>(options.open_timeout_s));
  }
  const av::LogScope log;
  AVFormatContext* raw = avformat_alloc_context();
  if (raw == nullptr) throw std::bad_alloc();
  raw->interrupt_callback = {&Patience::is_over, &patience};
  OptionList list;
  if (options.live) {
    raw->flags |= AVFMT_FLAG_NOBUFFER;
    raw->max_analyze_duration = AV_TIME_BASE / 2;
    list.set("rtsp_transport", "tcp");  // lost UDP packets would be holes in the picture
    list.set("fpsprobesize", "0");      // else some frames are kept back to guess the rate
    list.set("tcp_nodelay", "1");
  }
  int status = avformat_open_input(&raw, address.c_str(), nullptr, list.get());  // frees raw on failure
  if (status < 0) fail_open(status, log.first(), options);
  format.reset(raw);
  // Looking into the stream reads many frames, which with a slow camera takes seconds; a network camera's
  // protocol usually has said all that is needed.
  if (!options.live || !video_is_known()) {
    status = avformat_find_stream_info(format.get(), nullptr);
    if (status < 0) fail_open(status, log.first(), options);
  }
  stream = av_find_best_stream(format.get(), AVMEDIA_TYPE_VIDEO, -1, -1, nullptr, 0);
  if (stream < 0) {
    if (patience.timed_out()) fail_open(0, "", options);
    fail("holds no video that FFmpeg can decode");
  }
  for (unsigned other = 0; other < format->nb_streams; ++other) {
    if (static_cast<int>(other) != stream) format->streams[other]->discard = AVDISCARD_ALL;
  }
  const AVCodecParameters* const parameters = format->streams[stream]->codecpar;
  try {
    decoder = av::make_decoder(parameters->codec_id, parameters,
                               stands_alone(parameters->codec_id) ? AV_EF_EXPLODE | AV_EF_CRCCHECK : 0);
  } catch (const Error& error) {
    fail(error.what());
  }
  decoder->pkt_timebase = format->streams[stream]->time_base;
  if (options.live) decoder->flags |= AV_CODEC_FLAG_LOW_DELAY;

  Step step = decode_next();
  // A stream that is entered midway begins with pictures that lack what they refer to.
  while (options.live && step == Step::Damaged && !Patience::is_over(&patience)) step = decode_next();
  if (step != Step::Frame) {
    fail_open(0, "its first frame is unreadable" + (problem.empty() ? "" : ": " + problem), options);
  }
  first_pending = true;
  patience.deadline = Clock::time_point::max();
}

/// One packet of a codec without reordering gives one frame; a packet that gives none but an error is counted
/// as one damaged frame, so that the frames after it keep their numbers.
VideoDecoder::Step VideoDecoder::Impl::decode_next() {
  av::LogScope log;
  for (;;) {
    int status = avcodec_receive_frame(decoder.get(), frame.get());
    if (status >= 0) {
      size = {static_cast<std::uint32_t>(frame->width), static_cast<std::uint32_t>(frame->height)};
      const bool logged = stands_alone(decoder->codec_id) && log.had_error();
      if (logged || frame->decode_error_flags != 0 || (frame->flags & AV_FRAME_FLAG_CORRUPT) != 0) {
        problem = log.had_error() ? log.first() : "the stream has holes";
        return Step::Damaged;
      }
      return Step::Frame;
    }
    if (status == AVERROR_EOF) return Step::End;
    if (status != AVERROR(EAGAIN)) {
      problem = log.had_error() ? log.first() : av::error_text(status);
      return Step::Damaged;
    }
    if (draining) return Step::End;
    av_packet_unref(packet.get());
    status = av_read_frame(format.get(), packet.get());
    if (status == AVERROR(EAGAIN)) continue;
    if (status < 0) {
      if (status != AVERROR_EOF && !patience.stop.stop_requested()) {
        problem = log.had_error() ? log.first() : av::error_text(status);
      }
      draining = true;
      avcodec_send_packet(decoder.get(), nullptr);
      continue;
    }
    if (packet->stream_index != stream) continue;
    status = avcodec_send_packet(decoder.get(), packet.get());
    if (status < 0) {
      problem = log.had_error() ? log.first() : av::error_text(status);
      return Step::Damaged;
    }
  }
}

VideoDecoder::VideoDecoder(const std::string& address, const VideoDecoderOptions& options)
    : impl_(std::make_unique<Impl>()) {
  impl_->open(address, options);
}
VideoDecoder::~VideoDecoder() = default;
VideoDecoder::VideoDecoder(VideoDecoder&&) noexcept = default;
VideoDecoder& VideoDecoder::operator=(VideoDecoder&&) noexcept = default;

VideoDecoder::Step VideoDecoder::next() {
  if (impl_->first_pending) {
    impl_->first_pending = false;
    return Step::Frame;
  }
  return impl_->decode_next();
}

FrameSize VideoDecoder::size() const noexcept { return impl_->size; }
bool VideoDecoder::deep() const noexcept { return av::is_deep(*impl_->frame); }

std::optional<double> VideoDecoder::time_s() const noexcept {
  const std::int64_t stamp = impl_->frame->best_effort_timestamp;
  // The macro is a C cast of an unsigned constant.
  if (stamp == std::numeric_limits<std::int64_t>::min()) return std::nullopt;
  const AVStream& stream = *impl_->format->streams[impl_->stream];
  const bool has_start = stream.start_time != std::numeric_limits<std::int64_t>::min();
  return static_cast<double>(stamp - (has_start ? stream.start_time : 0)) * av_q2d(stream.time_base);
}

bool VideoDecoder::copy_to(const GreyTarget& target) {
  if (impl_->converter.convert(*impl_->frame, target)) return true;
  impl_->problem = "its pixel format cannot be converted to grey";
  return false;
}

double VideoDecoder::rate_hz() const noexcept {
  const AVStream& stream = *impl_->format->streams[impl_->stream];
  const AVRational rate = stream.avg_frame_rate.num > 0 ? stream.avg_frame_rate : stream.r_frame_rate;
  return rate.num > 0 && rate.den > 0 ? av_q2d(rate) : 0.0;
}

std::uint64_t VideoDecoder::frames_promised() const noexcept {
  const std::int64_t frames = impl_->format->streams[impl_->stream]->nb_frames;
  return frames > 0 ? static_cast<std::uint64_t>(frames) : 0;
}

const std::string& VideoDecoder::problem() const noexcept { return impl_->problem; }

bool has_video_extension(const std::filesystem::path& path) {
  static const std::set<std::string> kExtensions{".mp4", ".m4v",  ".mov",  ".avi",   ".mkv",  ".webm",
                                                 ".mpg", ".ts",   ".mts",  ".mjpeg", ".mjpg", ".y4m",
                                                 ".nut", ".mpeg", ".h264", ".hevc",  ".wmv"};
  std::string extension = path.extension().string();
  for (char& letter : extension)
    letter = letter >= 'A' && letter <= 'Z' ? static_cast<char>(letter + 32) : letter;
  return kExtensions.contains(extension);
}

std::string without_password(const std::string& address) {
  const std::size_t scheme = address.find("://");
  if (scheme == std::string::npos) return address;
  const std::size_t begin = scheme + 3, end = address.find_first_of("/?#", begin);
  const std::size_t at = address.rfind('@', end);
  if (at == std::string::npos || at < begin) return address;
  return address.substr(0, begin) + address.substr(at + 1);
}

}  // namespace glint
