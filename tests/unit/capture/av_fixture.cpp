// SPDX-License-Identifier: MIT
// Encoding with FFmpeg, and reading sources dry.
#include "tests/unit/capture/av_fixture.hpp"

#include <gtest/gtest.h>

extern "C" {
#include <libavutil/pixdesc.h>
}

#include <cstring>
#include <stdexcept>

#include "host/base/error.hpp"
#include "host/capture/av_handles.hpp"

namespace glint::test {
namespace {

void require(int status, const std::string& what) {
  if (status < 0) throw std::runtime_error("fixture: " + what + ": " + av::error_text(status));
}

void fill(AVFrame& frame, const GreyImage& image) {
  const std::string format = av_get_pix_fmt_name(static_cast<AVPixelFormat>(frame.format));
  if (format == "pal8") {
    for (std::uint32_t n = 0; n < 256; ++n) {
      const std::uint32_t argb = 0xff000000U | n << 16U | n << 8U | n;
      std::memcpy(frame.data[1] + 4 * n, &argb, 4);
    }
  }
  for (std::uint32_t y = 0; y < image.height_px; ++y) {
    std::uint8_t* row = frame.data[0] + std::ptrdiff_t{y} * frame.linesize[0];
    for (std::uint32_t x = 0; x < image.width_px; ++x) {
      const std::uint8_t value = image.pixels[std::size_t{y} * image.width_px + x];
      const unsigned copies = format == "rgb24" || format == "bgr24" ? 3 : format == "gray16le" ? 2 : 1;
      for (unsigned copy = 0; copy < copies; ++copy) *row++ = value;
    }
  }
  if (format.starts_with("yuv")) {
    const int chroma_rows = (frame.height + 1) / 2;
    std::memset(frame.data[1], 128, static_cast<std::size_t>(frame.linesize[1] * chroma_rows));
    std::memset(frame.data[2], 128, static_cast<std::size_t>(frame.linesize[2] * chroma_rows));
  }
}

av::CodecPtr make_encoder(const std::string& name, const std::string& pixel_format, const GreyImage& like,
                          int rate_hz) {
  const AVCodec* const codec = avcodec_find_encoder_by_name(name.c_str());
  if (codec == nullptr) throw std::runtime_error("fixture: no encoder " + name);
  av::CodecPtr encoder(avcodec_alloc_context3(codec));
  encoder->width = static_cast<int>(like.width_px);
  encoder->height = static_cast<int>(like.height_px);
  encoder->pix_fmt = av_get_pix_fmt(pixel_format.c_str());
  encoder->time_base = {1, rate_hz};
  encoder->framerate = {rate_hz, 1};
  encoder->thread_count = 1;
  encoder->flags |= AV_CODEC_FLAG_QSCALE;
  encoder->global_quality = FF_QP2LAMBDA * 2;
  return encoder;
}

av::FramePtr make_picture(const AVCodecContext& encoder, const GreyImage& image) {
  av::FramePtr frame = av::make_frame();
  frame->format = encoder.pix_fmt;
  frame->width = encoder.width;
  frame->height = encoder.height;
  frame->quality = encoder.global_quality;
  require(av_frame_get_buffer(frame.get(), 0), "frame");
  fill(*frame, image);
  return frame;
}

}  // namespace

GreyImage pattern(std::uint32_t width_px, std::uint32_t height_px, unsigned n) {
  GreyImage image{width_px, height_px, {}};
  for (std::uint32_t y = 0; y < height_px; ++y) {
    for (std::uint32_t x = 0; x < width_px; ++x) {
      image.pixels.push_back(static_cast<std::uint8_t>(x * 7 + y * 13 + (x * y) / 5 + n * 31));
    }
  }
  return image;
}

GreyImage smooth(std::uint32_t width_px, std::uint32_t height_px, unsigned level) {
  GreyImage image{width_px, height_px, {}};
  for (std::uint32_t y = 0; y < height_px; ++y) {
    for (std::uint32_t x = 0; x < width_px; ++x) {
      image.pixels.push_back(static_cast<std::uint8_t>(level + (x + y) * 16 / (width_px + height_px)));
    }
  }
  return image;
}

std::string encode_image(const std::string& kind, const std::string& pixel_format, const GreyImage& image) {
  const av::LogScope log;
  const av::CodecPtr encoder = make_encoder(kind, pixel_format, image, 25);
  require(avcodec_open2(encoder.get(), nullptr, nullptr), kind);
  const av::FramePtr frame = make_picture(*encoder, image);
  const av::PacketPtr packet = av::make_packet();
  require(avcodec_send_frame(encoder.get(), frame.get()), kind);
  require(avcodec_receive_packet(encoder.get(), packet.get()), kind);
  return {reinterpret_cast<const char*>(packet->data), static_cast<std::size_t>(packet->size)};
}

std::string encode_pgm(const GreyImage& image) {
  std::string file =
      "P5\n" + std::to_string(image.width_px) + " " + std::to_string(image.height_px) + "\n255\n";
  return file.append(image.pixels.begin(), image.pixels.end());
}

void write_video(const std::filesystem::path& path, const VideoSpec& spec,
                 const std::vector<GreyImage>& frames) {
  const av::LogScope log;
  std::filesystem::create_directories(path.parent_path());
  const av::CodecPtr encoder = make_encoder(spec.encoder, spec.pixel_format, frames.at(0), spec.rate_hz);
  AVFormatContext* raw = nullptr;
  require(avformat_alloc_output_context2(&raw, nullptr, nullptr, path.c_str()), path.string());
  struct FreeOutput {
    void operator()(AVFormatContext* context) const {
      avio_closep(&context->pb);
      avformat_free_context(context);
    }
  };
  const std::unique_ptr<AVFormatContext, FreeOutput> muxer(raw);
  if ((muxer->oformat->flags & AVFMT_GLOBALHEADER) != 0) encoder->flags |= AV_CODEC_FLAG_GLOBAL_HEADER;
  require(avcodec_open2(encoder.get(), nullptr, nullptr), spec.encoder);
  AVStream* const stream = avformat_new_stream(muxer.get(), nullptr);
  require(avcodec_parameters_from_context(stream->codecpar, encoder.get()), "parameters");
  stream->time_base = encoder->time_base;
  stream->avg_frame_rate = encoder->framerate;
  require(avio_open(&muxer->pb, path.c_str(), AVIO_FLAG_WRITE), path.string());
  require(avformat_write_header(muxer.get(), nullptr), "header");
  const av::PacketPtr packet = av::make_packet();
  const auto drain = [&] {
    while (avcodec_receive_packet(encoder.get(), packet.get()) >= 0) {
      av_packet_rescale_ts(packet.get(), encoder->time_base, stream->time_base);
      packet->duration = av_rescale_q(1, encoder->time_base, stream->time_base);
      require(av_interleaved_write_frame(muxer.get(), packet.get()), "packet");
    }
  };
  for (std::size_t n = 0; n < frames.size(); ++n) {
    const av::FramePtr frame = make_picture(*encoder, frames[n]);
    frame->pts = static_cast<std::int64_t>(n);
    require(avcodec_send_frame(encoder.get(), frame.get()), "frame");
    drain();
  }
  require(avcodec_send_frame(encoder.get(), nullptr), "end");
  drain();
  require(av_write_trailer(muxer.get()), "trailer");
}

std::vector<FrameSize> sizes_of(const FrameSource& source) {
  std::vector<FrameSize> sizes;
  for (const SourceCamera& camera : source.cameras()) sizes.push_back(camera.size);
  return sizes;
}

std::vector<ReadSet> read_all(FrameSource& source, ReadStatus& last, std::size_t limit) {
  FramePool pool(sizes_of(source), 2);
  std::vector<ReadSet> sets;
  FrameSet set;
  while (sets.size() < limit && (last = source.read(pool, set)) == ReadStatus::Ok) {
    ReadSet copy{
        number(set.trigger), std::chrono::duration<double>(set.exposed.time_since_epoch()).count(), {}};
    for (std::size_t n = 0; n < source.cameras().size(); ++n) {
      copy.frames.emplace_back();
      if (!set.frames[n]) continue;
      const gpu::ImageView view = set.frames[n]->image();
      GreyImage image{view.width_px, view.height_px, {}};
      for (std::size_t y = 0; y < view.height_px; ++y) {
        const std::uint8_t* const row = view.pixels + y * view.stride_bytes;
        image.pixels.insert(image.pixels.end(), row, row + view.width_px);
      }
      copy.frames.back() = ReadFrame{set.frames[n]->sequence, set.frames[n]->stamped, std::move(image)};
    }
    sets.push_back(std::move(copy));
  }
  return sets;
}

std::string error_of(const std::function<void()>& action) {
  try {
    action();
  } catch (const Error& error) {
    return error.what();
  }
  ADD_FAILURE() << "no error was thrown";
  return "";
}

}  // namespace glint::test
