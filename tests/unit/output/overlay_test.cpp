// SPDX-License-Identifier: MIT
// Boxes and crosses land where the blobs are, and nowhere outside the image.
#include "host/output/overlay.hpp"

#include <array>
#include <limits>
#include <vector>

#include <gtest/gtest.h>

namespace glint {
namespace {

using Rgb = std::array<int, 3>;

class OverlayTest : public testing::Test {
 protected:
  static constexpr std::uint32_t kWidth = 64, kHeight = 48, kStride = 80;
  OverlayTest() : grey_(kStride * kHeight, 200) {
    for (std::uint32_t y = 0; y < kHeight; ++y) {
      for (std::uint32_t x = 0; x < kWidth; ++x) grey_[y * kStride + x] = static_cast<std::uint8_t>(x + y);
    }
  }

  void draw(const std::vector<shaders::BlobRecord>& blobs, OverlayLabel label = OverlayLabel::None) {
    draw_overlay({grey_.data(), kWidth, kHeight, kStride}, blobs, {label, 2}, rgb_);
    ASSERT_EQ(rgb_.size(), kWidth * kHeight * 3u);
  }
  Rgb at(std::uint32_t x, std::uint32_t y) const {
    const std::size_t i = (std::size_t{y} * kWidth + x) * 3;
    return {rgb_[i], rgb_[i + 1], rgb_[i + 2]};
  }
  bool grey(std::uint32_t x, std::uint32_t y) const {
    const int v = static_cast<int>(x + y);
    return at(x, y) == Rgb{v, v, v};
  }
  int changed() const {
    int count = 0;
    for (std::uint32_t y = 0; y < kHeight; ++y) {
      for (std::uint32_t x = 0; x < kWidth; ++x) count += grey(x, y) ? 0 : 1;
    }
    return count;
  }

  std::vector<std::uint8_t> grey_, rgb_;
};

shaders::BlobRecord blob(std::uint32_t x0, std::uint32_t y0, std::uint32_t x1, std::uint32_t y1) {
  shaders::BlobRecord b{};
  b.x_min_px = x0;
  b.y_min_px = y0;
  b.x_max_px = x1;
  b.y_max_px = y1;
  b.x_px = static_cast<float>(x0 + x1) / 2;
  b.y_px = static_cast<float>(y0 + y1) / 2;
  b.area_px = (x1 - x0 + 1) * (y1 - y0 + 1);
  return b;
}

TEST_F(OverlayTest, WithoutBlobsTheImageIsThere) {
  draw({});
  EXPECT_EQ(changed(), 0);
}

TEST_F(OverlayTest, DrawsABoxAroundAndACrossInside) {
  draw({blob(20, 20, 30, 26)});
  const Rgb box = at(18, 18), cross = at(25, 23);
  EXPECT_EQ(at(32, 28), box);
  EXPECT_EQ(at(25, 18), box);
  EXPECT_EQ(at(18, 22), box);
  EXPECT_EQ(at(23, 23), cross);
  EXPECT_EQ(at(25, 25), cross);
  EXPECT_NE(box, cross);
  EXPECT_FALSE(grey(18, 18));
  EXPECT_TRUE(grey(17, 18));
  EXPECT_TRUE(grey(20, 20));  // the blob itself stays visible
  EXPECT_EQ(changed(), 2 * 15 + 2 * 9 + 9);
}

TEST_F(OverlayTest, DoubtfulBlobsHaveAnotherColour) {
  auto good = blob(20, 20, 21, 21), saturated = good, border = good;
  saturated.flags = shaders::kBlobSaturated;
  border.flags = shaders::kBlobOnBorder | shaders::kBlobSaturated;
  draw({good});
  const Rgb a = at(18, 18);
  draw({saturated});
  const Rgb b = at(18, 18);
  draw({border});
  const Rgb c = at(18, 18);
  EXPECT_NE(a, b);
  EXPECT_NE(b, c);
  EXPECT_NE(a, c);
}

TEST_F(OverlayTest, CornersAndNonsenseStayInside) {
  auto nowhere = blob(5, 5, 6, 6);
  nowhere.x_px = std::numeric_limits<float>::quiet_NaN();
  auto far_away = blob(0xfffffff0u, 0xfffffff0u, 0xffffffffu, 0xffffffffu);
  far_away.x_px = -1e30f;
  far_away.y_px = 1e30f;
  for (const OverlayLabel label : {OverlayLabel::None, OverlayLabel::Area, OverlayLabel::Number}) {
    draw({blob(0, 0, 0, 0), blob(63, 47, 63, 47), blob(0, 0, 63, 47), nowhere, far_away}, label);
  }
  EXPECT_GT(changed(), 0);
}

TEST_F(OverlayTest, LabelsWriteTheArea) {
  auto one = blob(30, 30, 30, 30);
  draw({one});
  const int without = changed();
  one.area_px = 1;
  draw({one}, OverlayLabel::Area);
  EXPECT_EQ(changed() - without, 8 * 4);  // the digit 1 has 8 dots of 2 x 2 pixels
  one.area_px = 88;
  draw({one}, OverlayLabel::Area);
  EXPECT_EQ(changed() - without, 2 * 13 * 4);
}

TEST(Overlay, AnEmptyImageIsNoTrouble) {
  std::vector<std::uint8_t> rgb(5);
  draw_overlay({nullptr, 0, 0, 0}, {}, {}, rgb);
  EXPECT_TRUE(rgb.empty());
}

}  // namespace
}  // namespace glint
