// SPDX-License-Identifier: MIT
// Images and videos made at run time for the tests of host/capture.
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "host/capture/image_file.hpp"
#include "host/frames/source.hpp"

namespace glint::test {

/// A picture without two equal rows that changes with n.
GreyImage pattern(std::uint32_t width_px, std::uint32_t height_px, unsigned n);
/// A picture that survives lossy compression well: brightness `level` with a soft slope.
GreyImage smooth(std::uint32_t width_px, std::uint32_t height_px, unsigned level);

/// kind: FFmpeg's encoder ("png", "tiff", "mjpeg", "bmp"); pixel_format: FFmpeg's name ("gray", "rgb24",
/// "gray16le", "pal8", "yuvj420p"). Grey goes into all channels; 16-bit values are the 8-bit ones times 257.
std::string encode_image(const std::string& kind, const std::string& pixel_format, const GreyImage& image);
std::string encode_pgm(const GreyImage& image);

struct VideoSpec {
  std::string encoder;       // "mjpeg", "mpeg4", "ffv1"
  std::string pixel_format;  // "yuvj420p", "yuv420p", "gray"
  int rate_hz = 25;
};
/// The container follows from the file name.
void write_video(const std::filesystem::path& path, const VideoSpec& spec,
                 const std::vector<GreyImage>& frames);

/// What a source gave, copied out.
struct ReadFrame {
  std::uint32_t sequence = 0;
  Timestamp stamped{};
  GreyImage image;
};
struct ReadSet {
  std::uint64_t trigger = 0;
  double exposed_s = 0.0;
  std::vector<std::optional<ReadFrame>> frames;
};
/// Reads until the end, at most `limit` sets; the final status goes to `last`.
std::vector<ReadSet> read_all(FrameSource& source, ReadStatus& last, std::size_t limit = 10'000);
std::vector<FrameSize> sizes_of(const FrameSource& source);

/// The text of the Error that `action` throws; fails the test if it throws none.
std::string error_of(const std::function<void()>& action);

}  // namespace glint::test
