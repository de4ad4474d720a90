// SPDX-License-Identifier: MIT
// What a camera's JPEG compression does to a grey image.
#pragma once

#include <cstdint>
#include <memory>
#include <vector>

namespace glint::sim {

/// Thread-bound.
class JpegRoundTrip {
 public:
  /// quality 1..100. Throws Error.
  JpegRoundTrip(std::uint32_t width_px, std::uint32_t height_px, int quality);
  /// Compresses the image and puts the decompressed one in its place. False if the library failed.
  [[nodiscard]] bool apply(std::uint8_t* pixels, std::uint32_t stride_bytes) noexcept;

 private:
  struct Close {
    void operator()(void* handle) const noexcept;
  };
  std::uint32_t width_px_ = 0, height_px_ = 0;
  int quality_ = 0;
  std::unique_ptr<void, Close> compressor_, decompressor_;
  std::vector<unsigned char> bytes_;
};

}  // namespace glint::sim
