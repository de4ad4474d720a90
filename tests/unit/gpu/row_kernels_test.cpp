// SPDX-License-Identifier: MIT
// Each instruction set's row kernels against plain loops, in memory that ends where the row ends.
#include "gpu/cpu/row_kernels.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <memory>
#include <random>
#include <string>
#include <tuple>
#include <vector>

namespace glint::gpu {
namespace {

class Random {
 public:
  std::uint32_t operator()() { return static_cast<std::uint32_t>(engine_()); }

 private:
  std::mt19937 engine_{7};
};

auto all_of(const BlobMoments& m) {
  return std::make_tuple(m.area, m.peak, m.x_min, m.y_min, m.x_max, m.y_max, m.sum, m.w, m.wx, m.wy, m.wxx,
                         m.wxy, m.wyy);
}

/// An image whose pixels end where its last row ends, for the address sanitizer.
struct Image {
  std::uint32_t width, height;
  std::size_t stride;
  std::unique_ptr<std::uint8_t[]> pixels;
  std::vector<std::uint8_t> limit, coarse;

  Image(std::uint32_t w, std::uint32_t h, std::uint32_t gap)
      : width(w),
        height(h),
        stride(w + gap),
        pixels(std::make_unique<std::uint8_t[]>(stride * (h - 1) + w)),
        limit(std::size_t{position_stride(w)} * h, 255),
        coarse(coarse_stride() * h, 255) {
    std::fill_n(pixels.get(), stride * (h - 1) + w, std::uint8_t{255});  // the gaps are bright
  }
  std::size_t coarse_stride() const { return width / kCoarsePixels + 1; }
  std::uint8_t& pixel(std::uint32_t x, std::uint32_t y) { return pixels[y * stride + x]; }
  std::uint8_t& limit_at(std::uint32_t x, std::uint32_t y) {
    return limit[std::size_t{y} * position_stride(width) + x];
  }
  void set(std::uint32_t x, std::uint32_t y, unsigned value, unsigned limit_value) {
    pixel(x, y) = static_cast<std::uint8_t>(value);
    limit_at(x, y) = static_cast<std::uint8_t>(limit_value);
    std::uint8_t& least = coarse[y * coarse_stride() + x / kCoarsePixels];
    least = std::min(least, limit_at(x, y));
  }
  Rows rows() const { return {pixels.get(), limit.data(), coarse.data(), stride, coarse_stride(), width}; }
};

Image random_image(Random& random, std::uint32_t width, std::uint32_t height, unsigned percent_switch,
                   unsigned percent_dark_rows) {
  Image image(width, height, random() % 3 * 7);
  bool bright = random() % 2 == 0;
  for (std::uint32_t y = 0; y < height; ++y) {
    const bool dark_row = random() % 100 < percent_dark_rows;
    for (std::uint32_t x = 0; x < width; ++x) {
      if (random() % 100 < percent_switch) bright = !bright;
      const unsigned limit = random() % 255;
      image.set(x, y, bright && !dark_row ? limit + 1 + random() % (255 - limit) : random() % (limit + 1),
                limit);
    }
  }
  return image;
}

/// All runs from row `y` on, found in as many calls as it takes.
std::vector<PixelRun> find_all(const RowKernels& kernels, const Image& image, std::uint32_t y,
                               std::uint32_t y_end) {
  std::vector<PixelRun> all, runs(most_runs_found(image.width) + 2);
  while (y < y_end) {
    const FoundRuns found = kernels.find(image.rows(), y, y_end, runs.data());
    EXPECT_GT(found.y, y);
    EXPECT_LE(found.y, y_end);
    EXPECT_LE(found.runs, most_runs_found(image.width));
    if (found.y <= y) break;
    for (std::uint32_t r = 0; r < found.runs; ++r) {
      EXPECT_LT(runs[r].begin / position_stride(image.width), found.y);
      all.push_back(runs[r]);
    }
    y = found.y;
  }
  return all;
}

std::string kernels_name(const ::testing::TestParamInfo<RowKernels>& info) { return info.param.name; }

class Kernels : public ::testing::TestWithParam<RowKernels> {};

TEST_P(Kernels, FindAndSumRunsAsPlainLoopsDo) {
  Random random;
  std::vector<std::uint32_t> widths = {1,   2,   15,  16,  17,  31,  32,  33,  63,  64,  65,  127, 128,
                                       129, 191, 255, 256, 257, 300, 319, 320, 511, 512, 513, 640, 1280};
  for (int i = 0; i < 60; ++i) widths.push_back(1 + random() % 700);
  widths.push_back(4096 + 64 + 3);
  for (const std::uint32_t width : widths) {
    for (const unsigned percent_switch : {0u, 1u, 5u, 20u, 50u, 100u}) {
      const std::uint32_t height = 1 + random() % 12;
      Image image = random_image(random, width, height, percent_switch, random() % 3 * 40);
      const std::uint32_t y_begin = random() % height, stride = position_stride(width);
      const std::vector<PixelRun> runs = find_all(GetParam(), image, y_begin, height);
      std::vector<BlobMoments> sums(runs.size());
      GetParam().measure(image.rows(), runs.data(), static_cast<std::uint32_t>(runs.size()), sums.data());
      std::size_t r = 0;
      for (std::uint32_t y = y_begin; y < height; ++y) {
        for (std::uint32_t x = 0; x < width; ++x) {
          const auto bright = [&] { return x < width && image.pixel(x, y) > image.limit_at(x, y); };
          if (!bright()) continue;
          BlobMoments m;
          m.x_min = x, m.y_min = m.y_max = y;
          for (; bright(); ++x) {
            const std::uint64_t value = image.pixel(x, y), w = value - image.limit_at(x, y), x64 = x, y64 = y;
            m.area += 1, m.sum += value, m.w += w, m.wx += w * x64, m.wy += w * y64, m.wxx += w * x64 * x64;
            m.wxy += w * x64 * y64, m.wyy += w * y64 * y64;
            m.peak = std::max(m.peak, static_cast<std::uint32_t>(value));
          }
          m.x_max = x - 1;
          ASSERT_LT(r, runs.size()) << width;
          ASSERT_EQ(runs[r].begin, y * stride + m.x_min) << width;
          ASSERT_EQ(runs[r].end, y * stride + x) << width;
          ASSERT_EQ(all_of(sums[r]), all_of(m)) << width;
          ++r;
        }
      }
      ASSERT_EQ(r, runs.size()) << width;
    }
  }
}

TEST_P(Kernels, SumTheLongestRun) {
  constexpr std::uint32_t kWidth = 65536, kHeight = 256;
  Image image(kWidth, kHeight, 0);
  const std::uint32_t y = kHeight - 1;
  for (std::uint32_t x = 0; x < kWidth; ++x) image.set(x, y, 255, 0);
  const std::vector<PixelRun> runs = find_all(GetParam(), image, y - 1, kHeight);
  ASSERT_EQ(runs.size(), 1u);
  BlobMoments m;
  GetParam().measure(image.rows(), runs.data(), 1, &m);
  const std::uint64_t n = kWidth, y64 = y;
  EXPECT_EQ(m.area, n);
  EXPECT_EQ(m.x_min, 0u);
  EXPECT_EQ(m.x_max, n - 1);
  EXPECT_EQ(m.y_min, y);
  EXPECT_EQ(m.sum, 255 * n);
  EXPECT_EQ(m.w, 255 * n);
  EXPECT_EQ(m.wx, 255 * (n * (n - 1) / 2));
  EXPECT_EQ(m.wxx, 255 * ((n - 1) * n * (2 * n - 1) / 6));
  EXPECT_EQ(m.wxy, 255 * y64 * (n * (n - 1) / 2));
  EXPECT_EQ(m.wyy, 255 * y64 * y64 * n);
}

TEST_P(Kernels, AgreeOnEveryPairOfValueAndLimit) {
  for (unsigned limit = 0; limit < 256; ++limit) {
    Image image(256, 1, 0);
    for (unsigned v = 0; v < 256; ++v) image.set(v, 0, v, limit);
    const std::vector<PixelRun> runs = find_all(GetParam(), image, 0, 1);
    ASSERT_EQ(runs.size(), limit < 255 ? 1u : 0u);
    if (limit < 255) {
      EXPECT_EQ(runs[0].begin, limit + 1);
      EXPECT_EQ(runs[0].end, 256u);
    }
  }
}

TEST(Positions, TellTheirRow) {
  for (const std::uint32_t width : {1u, 63u, 64u, 1000u, 1280u, 65535u, 65536u}) {
    const RowOfPosition row_of(width);
    const std::uint32_t stride = position_stride(width), last = (1u << 25) / stride - 1;
    for (std::uint32_t y = 0; y <= last; ++y) {
      ASSERT_EQ(row_of(y * stride), y);
      ASSERT_EQ(row_of(y * stride + stride - 1), y);
    }
  }
}

TEST(RowKernelTable, AlwaysHasThePlainOne) {
  ASSERT_FALSE(row_kernels().empty());
  EXPECT_STREQ(row_kernels().back().name, "portable");
}

INSTANTIATE_TEST_SUITE_P(All, Kernels, ::testing::ValuesIn(row_kernels().begin(), row_kernels().end()),
                         kernels_name);

}  // namespace
}  // namespace glint::gpu
