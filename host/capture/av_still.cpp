// SPDX-License-Identifier: MIT
// StillDecoder on libavcodec: whole files as single packets, without a demuxer in between (its probing stops
// at files whose directory lies behind the pixels, as most TIFFs' does).
#include <cerrno>
#include <cstdio>
#include <cstring>
#include <map>
#include <set>
#include <string_view>

#include "host/base/error.hpp"
#include "host/capture/av_grey.hpp"
#include "host/capture/av_handles.hpp"
#include "host/capture/still_decoder.hpp"

namespace glint {
namespace {

AVCodecID codec_of(std::string_view bytes) noexcept {
  using namespace std::string_view_literals;
  if (bytes.starts_with("\x89PNG\r\n\x1a\n"sv)) return AV_CODEC_ID_PNG;
  if (bytes.starts_with("II*\0"sv) || bytes.starts_with("MM\0*"sv)) return AV_CODEC_ID_TIFF;
  if (bytes.starts_with("\xff\xd8\xff"sv)) return AV_CODEC_ID_MJPEG;
  if (bytes.starts_with("BM"sv)) return AV_CODEC_ID_BMP;
  if (bytes.starts_with("P2"sv) || bytes.starts_with("P5"sv)) return AV_CODEC_ID_PGM;
  if (bytes.starts_with("P3"sv) || bytes.starts_with("P6"sv)) return AV_CODEC_ID_PPM;
  return AV_CODEC_ID_NONE;
}

int strictness_for(AVCodecID codec) noexcept {
  // FFmpeg's TIFF decoder counts harmless unknown tags as errors when it is told to be strict.
  return codec == AV_CODEC_ID_TIFF ? 0 : AV_EF_EXPLODE | AV_EF_CRCCHECK | AV_EF_BITSTREAM | AV_EF_BUFFER;
}

/// FFmpeg's JPEG decoder fills what is missing with grey and keeps quiet about it where the data ends on a
/// whole block; so the end marker must be there, and behind the scan: thumbnails in the header have their
/// own.
bool is_cut_jpeg(std::string_view bytes) noexcept {
  using namespace std::string_view_literals;
  constexpr unsigned char kStartOfScan = 0xda;
  const auto byte = [&](std::size_t at) { return static_cast<unsigned char>(bytes[at]); };
  std::size_t at = 2;
  while (at + 4 <= bytes.size() && byte(at) == 0xff && byte(at + 1) != kStartOfScan) {
    const bool fill = byte(at + 1) == 0xff;
    at += fill ? 1u : 2u + (std::size_t{byte(at + 2)} << 8u) + byte(at + 3);
  }
  return at >= bytes.size() || bytes.find("\xff\xd9"sv, at) == std::string_view::npos;
}

}  // namespace

struct StillDecoder::Impl {
  std::map<AVCodecID, av::CodecPtr> decoders;
  av::PacketPtr packet = av::make_packet();
  av::FramePtr frame = av::make_frame();
  av::GreyConverter converter;
  std::string problem, path;

  bool fail(const std::string& what) {
    problem = path + ": " + what;
    av_frame_unref(frame.get());
    return false;
  }
  bool read_file();
  bool decode();
};

bool StillDecoder::Impl::read_file() {
  struct Close {
    void operator()(std::FILE* file) const noexcept { std::fclose(file); }
  };
  errno = 0;
  const std::unique_ptr<std::FILE, Close> file(std::fopen(path.c_str(), "rb"));
  if (!file) return fail(std::strerror(errno));
  std::error_code no_size;
  const std::uintmax_t bytes = std::filesystem::file_size(path, no_size);
  if (no_size) return fail(no_size.message());
  if (bytes == 0) return fail("the file is empty");
  if (bytes > 0x3fffffffu) return fail("larger than 1 GiB, which no image of this program is");
  av_packet_unref(packet.get());
  if (av_new_packet(packet.get(), static_cast<int>(bytes)) < 0) return fail("no memory to read it");
  if (std::fread(packet->data, 1, bytes, file.get()) != bytes) {
    return fail(std::ferror(file.get()) != 0 ? std::strerror(errno) : "shrank while it was read");
  }
  return true;
}

bool StillDecoder::Impl::decode() {
  const std::string_view bytes(reinterpret_cast<const char*>(packet->data),
                               static_cast<std::size_t>(packet->size));
  const AVCodecID codec = codec_of(bytes);
  if (codec == AV_CODEC_ID_NONE) return fail("not a PGM, PPM, PNG, TIFF, JPEG or BMP image");
  if (codec == AV_CODEC_ID_MJPEG && is_cut_jpeg(bytes)) return fail("damaged JPEG: its end is missing");
  av::CodecPtr& decoder = decoders[codec];
  if (!decoder) decoder = av::make_decoder(codec, nullptr, strictness_for(codec));
  const av::LogScope log;
  avcodec_flush_buffers(decoder.get());
  packet->flags |= AV_PKT_FLAG_KEY;
  int status = avcodec_send_packet(decoder.get(), packet.get());
  if (status >= 0) status = avcodec_receive_frame(decoder.get(), frame.get());
  // Some damage is only logged: the picture then has holes, and is not used.
  if (status < 0 || log.had_error() || frame->decode_error_flags != 0 ||
      (frame->flags & AV_FRAME_FLAG_CORRUPT) != 0) {
    const std::string why = log.had_error() ? log.first() : status < 0 ? av::error_text(status) : "holes";
    return fail(std::string("damaged ") + avcodec_get_name(codec) + " image: " + why);
  }
  return true;
}

StillDecoder::StillDecoder() : impl_(std::make_unique<Impl>()) {}
StillDecoder::~StillDecoder() = default;
StillDecoder::StillDecoder(StillDecoder&&) noexcept = default;
StillDecoder& StillDecoder::operator=(StillDecoder&&) noexcept = default;

bool StillDecoder::load(const std::filesystem::path& path) {
  impl_->path = path.string();
  impl_->problem.clear();
  av_frame_unref(impl_->frame.get());
  if (!impl_->read_file() || !impl_->decode()) return false;
  const FrameSize size = this->size();
  if (std::uint64_t{size.width_px} * size.height_px > gpu::kMaxPixels) {
    return impl_->fail("has " + std::to_string(size.width_px) + "x" + std::to_string(size.height_px) +
                       " pixels, more than " + std::to_string(gpu::kMaxPixels));
  }
  return true;
}

FrameSize StillDecoder::size() const noexcept {
  return {static_cast<std::uint32_t>(impl_->frame->width), static_cast<std::uint32_t>(impl_->frame->height)};
}

bool StillDecoder::deep() const noexcept { return av::is_deep(*impl_->frame); }

bool StillDecoder::copy_to(const GreyTarget& target) {
  if (impl_->converter.convert(*impl_->frame, target)) return true;
  return impl_->fail("its pixel format cannot be converted to grey");
}

const std::string& StillDecoder::problem() const noexcept { return impl_->problem; }

bool has_image_extension(const std::filesystem::path& path) {
  static const std::set<std::string> kExtensions{".pgm",  ".ppm", ".pnm",  ".png", ".tif",
                                                 ".tiff", ".jpg", ".jpeg", ".bmp"};
  std::string extension = path.extension().string();
  for (char& letter : extension)
    letter = letter >= 'A' && letter <= 'Z' ? static_cast<char>(letter + 32) : letter;
  return kExtensions.contains(extension);
}

}  // namespace glint
