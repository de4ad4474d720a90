// SPDX-License-Identifier: MIT
// One image file after another to grey. Free of FFmpeg's headers.
#pragma once

#include <filesystem>
#include <memory>
#include <string>

#include "host/capture/grey_target.hpp"

namespace glint {

/// Whether the file name ends like an image that StillDecoder reads.
bool has_image_extension(const std::filesystem::path& path);

/// Keeps its decoder and buffers between files. Thread-bound.
class StillDecoder {
 public:
  StillDecoder();
  ~StillDecoder();
  StillDecoder(StillDecoder&&) noexcept;
  StillDecoder& operator=(StillDecoder&&) noexcept;

  /// Reads and decodes a whole file; the kind is told by its first bytes. False if it is unreadable, not an
  /// image, or damaged or cut anywhere: problem() says how, naming the file.
  [[nodiscard]] bool load(const std::filesystem::path& path);
  /// Of the image loaded last.
  FrameSize size() const noexcept;
  /// Whether it had more than 8 bits a pixel.
  bool deep() const noexcept;
  /// Writes it as grey; `target` must have its size. False, with problem(), if the pixel format is unknown.
  [[nodiscard]] bool copy_to(const GreyTarget& target);
  const std::string& problem() const noexcept;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace glint
