// SPDX-License-Identifier: MIT
// Files that are written whole or not at all.
#include "host/capture/image_file.hpp"

#include <cerrno>
#include <cstdio>
#include <cstring>
#include <memory>
#include <string>
#include <string_view>

#include "host/base/check.hpp"
#include "host/base/error.hpp"
#include "host/capture/png_encoder.hpp"
#include "host/capture/still_decoder.hpp"

namespace glint {
namespace {

namespace fs = std::filesystem;

struct Close {
  void operator()(std::FILE* file) const noexcept { std::fclose(file); }
};

[[noreturn]] void fail_write(const fs::path& path, int reason) {
  throw Error(path.string() + ": cannot be written: " + std::strerror(reason));
}

/// Writes all parts to a new file. On failure the file is removed, but only if it is a plain file: the path
/// may be a device.
void write_file(const fs::path& path, std::initializer_list<std::span<const std::uint8_t>> parts) {
  errno = 0;
  std::unique_ptr<std::FILE, Close> file(std::fopen(path.c_str(), "wb"));
  if (!file) fail_write(path, errno);
  bool good = true;
  for (const auto part : parts) {
    good = good && std::fwrite(part.data(), 1, part.size(), file.get()) == part.size();
  }
  good = good && std::fflush(file.get()) == 0;
  int reason = errno;
  if (std::fclose(file.release()) != 0 && good) {
    good = false;
    reason = errno;
  }
  if (good) return;
  std::error_code ignored;
  if (fs::is_regular_file(path, ignored)) fs::remove(path, ignored);
  fail_write(path, reason);
}

std::vector<std::uint8_t> without_gaps(const gpu::ImageView& image) {
  GLINT_CHECK(image.pixels != nullptr && image.stride_bytes >= image.width_px);
  std::vector<std::uint8_t> pixels(std::size_t{image.width_px} * image.height_px);
  for (std::size_t y = 0; y < image.height_px; ++y) {
    std::memcpy(pixels.data() + y * image.width_px, image.pixels + y * image.stride_bytes, image.width_px);
  }
  return pixels;
}

}  // namespace

GreyImage read_grey_image(const fs::path& path) {
  StillDecoder decoder;
  if (!decoder.load(path)) throw Error(decoder.problem());
  const FrameSize size = decoder.size();
  GreyImage image{size.width_px, size.height_px, {}};
  image.pixels.resize(std::size_t{size.width_px} * size.height_px);
  if (!decoder.copy_to({image.pixels.data(), size.width_px, size})) throw Error(decoder.problem());
  return image;
}

void write_png_grey(const fs::path& path, const gpu::ImageView& image) {
  const std::vector<std::uint8_t> pixels = without_gaps(image);
  const auto png = encode_png(image.width_px, image.height_px, 1, pixels);
  write_file(path, {png});
}

void write_png_rgb(const fs::path& path, std::uint32_t width_px, std::uint32_t height_px,
                   std::span<const std::uint8_t> rgb) {
  GLINT_CHECK(rgb.size() == std::size_t{width_px} * height_px * 3);
  const auto png = encode_png(width_px, height_px, 3, rgb);
  write_file(path, {png});
}

void write_pgm(const fs::path& path, const gpu::ImageView& image) {
  const std::vector<std::uint8_t> pixels = without_gaps(image);
  const std::string header =
      "P5\n" + std::to_string(image.width_px) + " " + std::to_string(image.height_px) + "\n255\n";
  write_file(path, {{reinterpret_cast<const std::uint8_t*>(header.data()), header.size()}, pixels});
}

}  // namespace glint
