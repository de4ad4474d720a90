// SPDX-License-Identifier: MIT
// A video file or a network camera, frame by frame, to grey. Free of FFmpeg's headers.
#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <stop_token>
#include <string>

#include "host/capture/grey_target.hpp"

namespace glint {

/// Whether the file name ends like a video.
bool has_video_extension(const std::filesystem::path& path);

/// An address without user name and password, for messages.
std::string without_password(const std::string& address);

struct VideoDecoderOptions {
  bool live = false;            ///< network camera: as little delay as the protocol allows
  double open_timeout_s = 0.0;  ///< until the first frame; 0: none
  std::stop_token stop;         ///< makes a blocked next() return End
};

/// Thread-bound; may be made in one thread and used in another.
class VideoDecoder {
 public:
  /// Opens it and decodes up to the first frame. Throws Error naming the address, without password.
  VideoDecoder(const std::string& address, const VideoDecoderOptions& options);
  ~VideoDecoder();
  VideoDecoder(VideoDecoder&&) noexcept;
  VideoDecoder& operator=(VideoDecoder&&) noexcept;

  enum class Step : std::uint8_t {
    Frame,
    Damaged,  ///< there was a frame, but it has holes; problem() says why
    End,      ///< problem() says why if it is not simply the end
  };
  /// Goes to the next frame; the first call gives the frame that the constructor decoded.
  Step next();

  /// Of the current frame; after construction, of the first.
  FrameSize size() const noexcept;
  bool deep() const noexcept;
  /// Seconds since the start of the stream, as stored; nothing where none is.
  std::optional<double> time_s() const noexcept;
  [[nodiscard]] bool copy_to(const GreyTarget& target);

  /// As the container says; 0 if it does not.
  double rate_hz() const noexcept;
  std::uint64_t frames_promised() const noexcept;
  const std::string& problem() const noexcept;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace glint
