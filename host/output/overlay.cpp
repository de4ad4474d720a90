// SPDX-License-Identifier: MIT
// Boxes, crosses and digits in an RGB image.
#include "host/output/overlay.hpp"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <cstddef>

#include "host/base/check.hpp"

namespace glint {

namespace {

struct Colour {
  std::uint8_t red, green, blue;
};
constexpr Colour kGood{60, 220, 120}, kSaturated{255, 180, 40}, kBad{255, 80, 80}, kCross{80, 160, 255};

constexpr float kFarthest = 1e6f;

constexpr int kDigitWidth = 3, kDigitHeight = 5, kDigitScale = 2;
// Rows of three dots, top first; bit 2 is the left dot.
constexpr std::array<std::array<std::uint8_t, kDigitHeight>, 10> kDigits{{{7, 5, 5, 5, 7},
                                                                          {2, 6, 2, 2, 7},
                                                                          {7, 1, 7, 4, 7},
                                                                          {7, 1, 7, 1, 7},
                                                                          {5, 5, 7, 1, 1},
                                                                          {7, 4, 7, 1, 7},
                                                                          {7, 4, 7, 5, 7},
                                                                          {7, 1, 2, 2, 2},
                                                                          {7, 5, 7, 5, 7},
                                                                          {7, 5, 7, 1, 7}}};

class Canvas {
 public:
  Canvas(const GreyPixels& image, std::vector<std::uint8_t>& rgb)
      : rgb_(rgb), width_(image.width_px), height_(image.height_px) {
    rgb_.resize(std::size_t{image.width_px} * image.height_px * 3);
    std::size_t to = 0;
    for (std::uint32_t y = 0; y < image.height_px; ++y) {
      const std::uint8_t* row = image.pixels + std::size_t{y} * image.stride_bytes;
      for (std::uint32_t x = 0; x < image.width_px; ++x, to += 3) {
        rgb_[to] = rgb_[to + 1] = rgb_[to + 2] = row[x];
      }
    }
  }

  void dot(std::int64_t x, std::int64_t y, Colour colour) noexcept {
    if (x < 0 || y < 0 || x >= width_ || y >= height_) return;
    const std::size_t at = static_cast<std::size_t>(y * width_ + x) * 3;
    rgb_[at] = colour.red;
    rgb_[at + 1] = colour.green;
    rgb_[at + 2] = colour.blue;
  }

  void box(std::int64_t x0, std::int64_t y0, std::int64_t x1, std::int64_t y1, Colour colour) noexcept {
    // Clipped first: a box is never walked outside the image.
    for (std::int64_t x = std::max<std::int64_t>(x0, 0); x <= std::min(x1, width_ - 1); ++x) {
      dot(x, y0, colour);
      dot(x, y1, colour);
    }
    for (std::int64_t y = std::max<std::int64_t>(y0, 0); y <= std::min(y1, height_ - 1); ++y) {
      dot(x0, y, colour);
      dot(x1, y, colour);
    }
  }

  void digits(std::int64_t left, std::int64_t top, std::uint32_t value, Colour colour) noexcept {
    std::array<char, 10> text{};
    const char* const end = std::to_chars(text.data(), text.data() + text.size(), value).ptr;
    for (const char* c = text.data(); c != end; ++c, left += (kDigitWidth + 1) * kDigitScale) {
      const auto& rows = kDigits[static_cast<std::size_t>(*c - '0')];
      for (int y = 0; y < kDigitHeight * kDigitScale; ++y) {
        for (int x = 0; x < kDigitWidth * kDigitScale; ++x) {
          const int bit = kDigitWidth - 1 - x / kDigitScale;
          if ((rows[static_cast<std::size_t>(y / kDigitScale)] >> bit & 1) != 0)
            dot(left + x, top + y, colour);
        }
      }
    }
  }

  std::int64_t width() const noexcept { return width_; }

 private:
  std::vector<std::uint8_t>& rgb_;
  std::int64_t width_, height_;
};

Colour colour_of(const shaders::BlobRecord& blob) noexcept {
  if ((blob.flags & (shaders::kBlobNotInvertible | shaders::kBlobOnBorder)) != 0) return kBad;
  if ((blob.flags & shaders::kBlobSaturated) != 0) return kSaturated;
  return kGood;
}

}  // namespace

void draw_overlay(const GreyPixels& image, std::span<const shaders::BlobRecord> blobs,
                  const OverlayOptions& options, std::vector<std::uint8_t>& rgb) {
  GLINT_CHECK(image.pixels != nullptr || image.width_px == 0 || image.height_px == 0);
  Canvas canvas(image, rgb);
  std::uint32_t blob_number = 0;
  for (const shaders::BlobRecord& blob : blobs) {
    ++blob_number;
    const Colour colour = colour_of(blob);
    const std::int64_t margin = options.margin_px;
    const std::int64_t x0 = std::int64_t{blob.x_min_px} - margin, x1 = std::int64_t{blob.x_max_px} + margin;
    const std::int64_t y0 = std::int64_t{blob.y_min_px} - margin, y1 = std::int64_t{blob.y_max_px} + margin;
    canvas.box(x0, y0, x1, y1, colour);
    // Not for NaN and what cannot be a pixel: it would not fit an integer either.
    if (std::abs(blob.x_px) < kFarthest && std::abs(blob.y_px) < kFarthest) {
      const std::int64_t x = std::lround(blob.x_px), y = std::lround(blob.y_px);
      for (std::int64_t arm = -2; arm <= 2; ++arm) {
        canvas.dot(x + arm, y, kCross);
        canvas.dot(x, y + arm, kCross);
      }
    }
    if (options.label == OverlayLabel::None) continue;
    const std::uint32_t value = options.label == OverlayLabel::Area ? blob.area_px : blob_number;
    const std::int64_t text_height = kDigitHeight * kDigitScale;
    // Above the box, or below it where the image ends.
    const std::int64_t top = y0 >= text_height + 2 ? y0 - text_height - 2 : y1 + 3;
    canvas.digits(std::max<std::int64_t>(x0, 0), top, value, colour);
  }
}

}  // namespace glint
