// SPDX-License-Identifier: MIT
// A file of JPEG frames of several cameras: what the virtual cameras send.
#pragma once

#include <cstdint>
#include <filesystem>
#include <fstream>
#include <span>
#include <vector>

namespace glint::device {

/// Little-endian: magic, then these; then `ticks` times the frames of all cameras, then one frame of each
/// camera without markers. A frame is its size in 4 bytes and the JPEG.
struct FrameFileHeader {
  std::uint32_t cameras = 0, width_px = 0, height_px = 0, ticks = 0;
  double rate_hz = 0.0;
};

/// Frames are added tick by tick, camera by camera, the dark ones last.
class FrameFileWriter {
 public:
  /// Throws Error.
  FrameFileWriter(std::filesystem::path path, const FrameFileHeader& header);
  void add(std::span<const std::uint8_t> jpeg);
  /// Throws Error if the file is not whole.
  void finish();

 private:
  std::filesystem::path path_;
  std::ofstream file_;
  std::uint64_t missing_ = 0;
};

/// The whole file in memory.
class FrameFile {
 public:
  /// Throws Error.
  explicit FrameFile(const std::filesystem::path& path);
  const FrameFileHeader& header() const noexcept { return header_; }
  /// Ticks beyond the last go back and forth, so that markers never jump.
  std::span<const std::uint8_t> frame(std::uint64_t tick, std::uint32_t camera) const noexcept;
  std::span<const std::uint8_t> dark(std::uint32_t camera) const noexcept;

 private:
  FrameFileHeader header_;
  std::vector<std::uint8_t> bytes_;
  std::vector<std::span<const std::uint8_t>> frames_;
};

/// Which tick of a file with `ticks` ticks is shown at `tick`.
std::uint64_t back_and_forth(std::uint64_t tick, std::uint64_t ticks) noexcept;

}  // namespace glint::device
