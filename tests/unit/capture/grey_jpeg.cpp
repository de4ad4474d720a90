// SPDX-License-Identifier: MIT
// Pictures through TurboJPEG.
#include "tests/unit/capture/grey_jpeg.hpp"

#include <turbojpeg.h>

#include <algorithm>
#include <cstdlib>
#include <memory>
#include <random>
#include <stdexcept>

namespace glint::test {

std::vector<std::uint8_t> disc_picture(std::uint32_t width_px, std::uint32_t height_px, unsigned seed) {
  std::mt19937 random(seed);
  std::vector<std::uint8_t> grey(std::size_t{width_px} * height_px);
  for (std::uint8_t& pixel : grey) pixel = static_cast<std::uint8_t>(6 + random() % 5);
  for (int disc = 0; disc < 6; ++disc) {
    const int cx = static_cast<int>(random() % width_px), cy = static_cast<int>(random() % height_px);
    for (int y = std::max(0, cy - 3); y < std::min<int>(static_cast<int>(height_px), cy + 4); ++y) {
      for (int x = std::max(0, cx - 3); x < std::min<int>(static_cast<int>(width_px), cx + 4); ++x) {
        if ((x - cx) * (x - cx) + (y - cy) * (y - cy) <= 9)
          grey[static_cast<std::size_t>(y) * width_px + static_cast<std::size_t>(x)] = 220;
      }
    }
  }
  return grey;
}

namespace {

/// `pixels`: grey, or red, green, blue.
std::vector<std::uint8_t> compress(const std::vector<std::uint8_t>& pixels, std::uint32_t width_px,
                                   std::uint32_t height_px, int quality, int sampling) {
  const std::unique_ptr<void, int (*)(void*)> compressor(tjInitCompress(), tjDestroy);
  const int width = static_cast<int>(width_px), height = static_cast<int>(height_px);
  std::vector<std::uint8_t> jpeg(tjBufSize(width, height, sampling) + 4096);  // restart markers need more
  unsigned char* out = jpeg.data();
  unsigned long bytes = jpeg.size();
  if (tjCompress2(compressor.get(), pixels.data(), width, 0, height,
                  sampling == TJSAMP_GRAY ? TJPF_GRAY : TJPF_RGB, &out, &bytes, sampling, quality,
                  TJFLAG_NOREALLOC) != 0)
    throw std::runtime_error(tjGetErrorStr2(compressor.get()));
  jpeg.resize(bytes);
  return jpeg;
}

}  // namespace

std::vector<std::uint8_t> jpeg_of(const std::vector<std::uint8_t>& grey, std::uint32_t width_px,
                                  std::uint32_t height_px, int quality, bool colour) {
  if (!colour) return compress(grey, width_px, height_px, quality, TJSAMP_GRAY);
  std::vector<std::uint8_t> rgb;
  for (const std::uint8_t pixel : grey) rgb.insert(rgb.end(), 3, pixel);
  return compress(rgb, width_px, height_px, quality, TJSAMP_422);
}

std::vector<std::uint8_t> sampled_jpeg_of(const std::vector<std::uint8_t>& grey, std::uint32_t width_px,
                                          std::uint32_t height_px, int quality, int sampling, bool restarts) {
  std::vector<std::uint8_t> rgb;
  for (std::size_t n = 0; n < grey.size() && sampling != TJSAMP_GRAY; ++n) {
    for (int channel = 0; channel < 3; ++channel)
      rgb.push_back(static_cast<std::uint8_t>(
          std::min(grey[n] + (channel == static_cast<int>(n / 40 % 3) ? 6 : 0), 255)));
  }
  if (restarts) setenv("TJ_RESTART", "1", 1);
  std::vector<std::uint8_t> jpeg =
      compress(sampling == TJSAMP_GRAY ? grey : rgb, width_px, height_px, quality, sampling);
  unsetenv("TJ_RESTART");
  return jpeg;
}

std::vector<std::uint8_t> without_huffman_tables(const std::vector<std::uint8_t>& jpeg) {
  std::vector<std::uint8_t> out(jpeg.begin(), jpeg.begin() + 2);
  for (std::size_t at = 2; at + 4 <= jpeg.size();) {
    const std::uint8_t marker = jpeg[at + 1];
    const std::size_t length = 2 + (std::size_t{jpeg[at + 2]} << 8 | jpeg[at + 3]);
    const auto begin = jpeg.begin() + static_cast<std::ptrdiff_t>(at);
    if (marker == 0xda) {  // the scan, to the end
      out.insert(out.end(), begin, jpeg.end());
      break;
    }
    if (marker != 0xc4) out.insert(out.end(), begin, begin + static_cast<std::ptrdiff_t>(length));
    at += length;
  }
  return out;
}

}  // namespace glint::test
