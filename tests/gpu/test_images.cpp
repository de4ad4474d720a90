// SPDX-License-Identifier: MIT
// Test images, drawn from masks.
#include "tests/gpu/test_images.hpp"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <new>

namespace glint::gpu::testing {
namespace {

/// Mersenne Twister in 32 bits, for that is what it gives.
class Random {
 public:
  explicit Random(std::uint32_t seed) : engine_(seed) {}
  std::uint32_t operator()() { return static_cast<std::uint32_t>(engine_()); }

 private:
  std::mt19937 engine_;
};

std::uint8_t grey(double v) { return static_cast<std::uint8_t>(std::clamp(v, 0.0, 255.0)); }

/// A one pixel wide path that winds inwards with a gap of one pixel.
std::vector<bool> spiral(std::uint32_t width, std::uint32_t height) {
  std::vector<bool> bright(std::size_t{width} * height);
  long x0 = 0, y0 = 0, x1 = static_cast<long>(width) - 1, y1 = static_cast<long>(height) - 1;
  const auto set = [&](long x, long y) {
    bright[static_cast<std::size_t>(y) * width + static_cast<std::size_t>(x)] = true;
  };
  long start = 0;
  while (x0 <= x1 && y0 <= y1) {
    for (long x = start; x <= x1; ++x) set(x, y0);
    for (long y = y0; y <= y1; ++y) set(x1, y);
    for (long x = x1; x >= x0; --x) set(x, y1);
    for (long y = y1; y >= y0 + 2; --y) set(x0, y);
    start = x0;
    x0 += 2, y0 += 2, x1 -= 2, y1 -= 2;
  }
  return bright;
}

}  // namespace

TestImage image_from_mask(std::string name, std::uint32_t width_px, std::uint32_t height_px, const Mask& mask,
                          std::uint32_t seed) {
  Random random(seed);
  TestImage image{std::move(name), width_px, height_px, {}, {}};
  for (std::uint32_t y = 0; y < height_px; ++y) {
    for (std::uint32_t x = 0; x < width_px; ++x) {
      const bool bright = mask(x, y);
      // Some dark pixels are masked for good, whatever their value.
      const std::uint32_t limit = !bright && random() % 16 == 0 ? 255 : 20 + random() % 180;
      const std::uint32_t value = bright ? limit + 1 + random() % (255 - limit) : random() % (limit + 1);
      image.limit.push_back(static_cast<std::uint8_t>(limit));
      image.pixels.push_back(static_cast<std::uint8_t>(value));
    }
  }
  return image;
}

TestImage noise_image(std::uint32_t width_px, std::uint32_t height_px, double density, std::uint32_t seed) {
  Random random(seed);
  const auto below = static_cast<std::uint32_t>(density * 4294967295.0);
  return image_from_mask(
      "noise " + std::to_string(std::lround(100 * density)) + " % " + std::to_string(width_px) + "x" +
          std::to_string(height_px),
      width_px, height_px, [&](std::uint32_t, std::uint32_t) { return random() < below; }, seed + 1);
}

TestImage all_white(std::uint32_t width_px, std::uint32_t height_px) {
  const std::size_t n = std::size_t{width_px} * height_px;
  return {"all white " + std::to_string(width_px) + "x" + std::to_string(height_px), width_px, height_px,
          std::vector<std::uint8_t>(n, 255), std::vector<std::uint8_t>(n, 0)};
}

TestImage all_black(std::uint32_t width_px, std::uint32_t height_px) {
  const std::size_t n = std::size_t{width_px} * height_px;
  return {"all black", width_px, height_px, std::vector<std::uint8_t>(n, 0), std::vector<std::uint8_t>(n, 0)};
}

TestImage soft_spots(std::uint32_t width_px, std::uint32_t height_px, unsigned count, double diameter_px,
                     std::uint32_t seed) {
  Random random(seed);
  const auto uniform = [&](double from, double to) { return from + (to - from) * random() / 4294967296.0; };
  std::vector<double> light(std::size_t{width_px} * height_px);
  for (unsigned i = 0; i < count; ++i) {
    const double cx = uniform(0, width_px), cy = uniform(0, height_px);
    const double r = uniform(1.5, 0.5 * diameter_px), amplitude = uniform(80, 300);
    const double reach = r + 3.0;
    const auto from = [](double v) { return static_cast<std::uint32_t>(std::max(0.0, v)); };
    for (std::uint32_t y = from(cy - reach); y < std::min<double>(height_px, cy + reach); ++y) {
      for (std::uint32_t x = from(cx - reach); x < std::min<double>(width_px, cx + reach); ++x) {
        light[std::size_t{y} * width_px + x] +=
            amplitude / (1.0 + std::exp(2.0 * (std::hypot(x - cx, y - cy) - r)));
      }
    }
  }
  TestImage image{std::to_string(count) + " soft spots", width_px, height_px, {}, {}};
  for (std::uint32_t y = 0; y < height_px; ++y) {
    for (std::uint32_t x = 0; x < width_px; ++x) {
      const double gradient = 5.0 + 60.0 * x / width_px + 30.0 * y / height_px;
      image.limit.push_back(grey(gradient + 25.0));
      image.pixels.push_back(grey(gradient + light[std::size_t{y} * width_px + x] + uniform(-3.0, 3.0)));
    }
  }
  return image;
}

TestImage dot_grid(std::uint32_t width_px, std::uint32_t height_px) {
  return image_from_mask(
      "dot grid", width_px, height_px,
      [](std::uint32_t x, std::uint32_t y) { return x % 2 == 0 && y % 2 == 0; }, 5);
}

std::vector<TestImage> shape_images(std::uint32_t width_px, std::uint32_t height_px) {
  using U = std::uint32_t;
  const U w = width_px, h = height_px;
  std::vector<TestImage> images;
  const auto add = [&](const char* name, const Mask& mask) {
    images.push_back(image_from_mask(name, w, h, mask, static_cast<std::uint32_t>(images.size()) + 100));
  };
  const std::vector<bool> winding = spiral(w, h);
  const auto distance = [&](U x, U y) { return std::hypot(x - 0.5 * w, y - 0.5 * h); };
  add("comb, teeth up", [&](U x, U y) { return x % 2 == 0 || y == h - 1; });
  add("comb, teeth down", [&](U x, U y) { return x % 2 == 0 || y == 0; });
  add("comb, teeth right", [&](U x, U y) { return y % 2 == 0 || x == 0; });
  add("comb, teeth left", [&](U x, U y) { return y % 2 == 0 || x == w - 1; });
  add("stripes", [&](U x, U) { return x % 2 == 0; });
  add("rows", [&](U, U y) { return y % 2 == 0; });
  add("spiral", [&](U x, U y) { return winding[std::size_t{y} * w + x]; });
  add("serpentine", [&](U x, U y) { return y % 2 == 0 || x == ((y / 2) % 2 == 0 ? w - 1 : 0); });
  add("checkerboard", [](U x, U y) { return (x + y) % 2 == 0; });
  add("checkerboard of 3", [](U x, U y) { return (x / 3 + y / 3) % 2 == 0; });
  add("checkerboard of 16x8", [](U x, U y) { return (x / 16 + y / 8) % 2 == 0; });
  add("dot grid", [](U x, U y) { return x % 2 == 0 && y % 2 == 0; });
  add("dots of 16x8", [](U x, U y) { return x % 16 == 15 && y % 8 == 7; });
  add("dots at tile corners",
      [](U x, U y) { return (x % 16 == 15 || x % 16 == 0) && (y % 8 == 7 || y % 8 == 0); });
  add("diagonals down", [](U x, U y) { return (x + 400 - y) % 4 == 0; });
  add("diagonals up", [](U x, U y) { return (x + y) % 4 == 0; });
  add("crossing diagonals", [](U x, U y) { return (x + y) % 12 == 0 || (x + 1200 - y) % 12 == 0; });
  add("rings", [&](U x, U y) { return static_cast<long>(distance(x, y)) % 4 < 2; });
  add("thin rings", [&](U x, U y) { return static_cast<long>(distance(x, y)) % 2 == 0; });
  add("discs", [](U x, U y) { return std::hypot(x % 24 - 11.5, y % 24 - 11.5) < 9.0; });
  // Arms that meet only at the bottom.
  add("U",
      [&](U x, U y) { return x % 12 == 1 || x % 12 == 9 || (y == h - 1 && x % 12 >= 1 && x % 12 <= 9); });
  add("nested U", [&](U x, U y) {
    const U depth = std::min(x, w - 1 - x);
    return depth % 2 == 0 || (y + depth + 1 >= h && (h - 1 - y) % 2 == 0);
  });
  add("W", [&](U x, U y) {
    const U zigzag = x % 16 < 8 ? x % 8 : 7 - x % 8;
    return (y + 300 - zigzag) % 10 < 1;
  });
  add("triangle of arms", [&](U x, U y) { return x % 2 == 0 ? true : y + 1 + (x % 32) / 2 >= h; });
  add("border", [&](U x, U y) { return x == 0 || y == 0 || x == w - 1 || y == h - 1; });
  add("corners", [&](U x, U y) { return (x == 0 || x == w - 1) && (y == 0 || y == h - 1); });
  add("every other border pixel", [&](U x, U y) {
    return ((y == 0 || y == h - 1) && x % 2 == 0) || ((x == 0 || x == w - 1) && y % 2 == 0);
  });
  add("one pixel", [&](U x, U y) { return x == w / 2 && y == h / 3; });
  add("one pixel is dark", [&](U x, U y) { return x != w / 2 || y != h / 3; });
  images.push_back(all_white(w, h));
  images.push_back(all_black(w, h));
  images.push_back(soft_spots(w, h, 12, 20.0, 77));
  return images;
}

Lens wide_lens(std::uint32_t width_px, std::uint32_t height_px) {
  const double f = 0.714 * std::max(width_px, height_px);
  return {f,
          1.01 * f,
          0.5 * (width_px - 1) + 0.01 * f,
          0.5 * (height_px - 1) - 0.02 * f,
          {-0.32, 0.12, 0.0006, -0.0004, -0.015}};
}

std::vector<CameraFormat> formats_of(std::span<const TestImage> images) {
  std::vector<CameraFormat> formats;
  for (const TestImage& image : images) {
    formats.push_back({image.width_px, image.height_px, wide_lens(image.width_px, image.height_px)});
  }
  return formats;
}

FrameMemory::FrameMemory(std::span<const TestImage> images, Layout layout) {
  constexpr std::size_t kPage = 4096;
  for (const TestImage& image : images) {
    const std::uint32_t stride =
        layout == Layout::Aligned ? (image.width_px + 15) / 16 * 16 : image.width_px + 3;
    if (layout == Layout::Aligned) {
      bytes_ = (bytes_ + kPage - 1) / kPage * kPage;
    } else {
      bytes_ += 1 + (bytes_ % 2);  // odd addresses
    }
    offsets_.push_back(bytes_);
    views_.push_back({nullptr, image.width_px, image.height_px, stride, PixelFormat::Grey8});
    bytes_ += std::size_t{stride} * ((image.height_px + 7) / 8 * 8);
  }
  bytes_ = (bytes_ + kPage - 1) / kPage * kPage;
  memory_.reset(static_cast<std::uint8_t*>(std::aligned_alloc(kPage, bytes_)));
  if (!memory_) throw std::bad_alloc();
  std::memset(memory_.get(), 255, bytes_);
  for (std::size_t i = 0; i < images.size(); ++i) {
    views_[i].pixels = memory_.get() + offsets_[i];
    write(i, images[i]);
  }
}

void FrameMemory::write(std::size_t camera, const TestImage& image) {
  if (image.pixels.empty()) return;
  for (std::size_t y = 0; y < image.height_px; ++y) {
    std::memcpy(memory_.get() + offsets_[camera] + y * views_[camera].stride_bytes,
                image.pixels.data() + y * image.width_px, image.width_px);
  }
}

}  // namespace glint::gpu::testing
