// SPDX-License-Identifier: MIT
// Each instruction set's row kernels against plain loops, in memory that ends where the row ends.
#include "gpu/cpu/row_kernels.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <memory>
#include <random>
#include <string>
#include <vector>

namespace glint::gpu {
namespace {

class Random {
 public:
  std::uint32_t operator()() { return static_cast<std::uint32_t>(engine_()); }

 private:
  std::mt19937 engine_{7};
};

struct Row {
  std::unique_ptr<std::uint8_t[]> pixels;  // exactly width bytes, for the address sanitizer
  std::vector<std::uint8_t> limit, coarse;
  std::uint32_t width = 0;
};

Row random_row(Random& random, std::uint32_t width, unsigned percent_switch) {
  Row row{std::make_unique<std::uint8_t[]>(width), {}, {}, width};
  row.limit.assign(width + kLimitPadding, 255);
  row.coarse.assign(width / kCoarsePixels + 1, 255);
  bool bright = random() % 2 == 0;
  for (std::uint32_t x = 0; x < width; ++x) {
    if (random() % 100 < percent_switch) bright = !bright;
    const std::uint32_t limit = random() % 255;
    row.limit[x] = static_cast<std::uint8_t>(limit);
    row.pixels[x] =
        static_cast<std::uint8_t>(bright ? limit + 1 + random() % (255 - limit) : random() % (limit + 1));
    std::uint8_t& coarse = row.coarse[x / kCoarsePixels];
    coarse = std::min(coarse, row.limit[x]);
  }
  return row;
}

std::string kernels_name(const ::testing::TestParamInfo<RowKernels>& info) { return info.param.name; }

class Kernels : public ::testing::TestWithParam<RowKernels> {};

TEST_P(Kernels, FindAndSumRunsAsPlainLoopsDo) {
  Random random;
  std::vector<std::uint32_t> widths = {1,   2,   15,  16,  17,  31,  32,  33,  63,  64,  65,  127, 128,
                                       129, 191, 255, 256, 257, 300, 319, 320, 511, 512, 513, 640, 1280};
  for (int i = 0; i < 60; ++i) widths.push_back(1 + random() % 700);
  for (const std::uint32_t width : widths) {
    for (const unsigned percent_switch : {0u, 1u, 5u, 20u, 50u, 100u}) {
      const Row row = random_row(random, width, percent_switch);
      std::vector<std::uint32_t> edges(edges_needed(width), 12345);
      const std::uint32_t runs = GetParam().scan(row.pixels.get(), row.limit.data(), row.limit.data(),
                                                 row.coarse.data(), width, edges.data());
      std::vector<std::uint32_t> expected;
      bool lit = false;
      for (std::uint32_t x = 0; x <= width; ++x) {
        const bool bright = x < width && row.pixels[x] > row.limit[x];
        if (bright != lit) expected.push_back(x);
        lit = bright;
      }
      ASSERT_EQ(2 * runs, expected.size()) << width;
      ASSERT_TRUE(std::equal(expected.begin(), expected.end(), edges.begin())) << width;

      std::vector<RunSums> sums(runs);
      GetParam().measure(row.pixels.get(), row.limit.data(), width, edges.data(), runs, sums.data());
      for (std::uint32_t r = 0; r < runs; ++r) {
        RunSums s{};
        for (std::uint32_t x = edges[2 * r]; x < edges[2 * r + 1]; ++x) {
          const std::uint32_t value = row.pixels[x], w = value - row.limit[x];
          const std::uint64_t i = x - edges[2 * r];
          s.sum += value, s.w += w, s.wi += w * i, s.wii += w * i * i, s.peak = std::max(s.peak, value);
        }
        ASSERT_EQ(sums[r].sum, s.sum) << width;
        ASSERT_EQ(sums[r].w, s.w) << width;
        ASSERT_EQ(sums[r].wi, s.wi) << width;
        ASSERT_EQ(sums[r].wii, s.wii) << width;
        ASSERT_EQ(sums[r].peak, s.peak) << width;
      }
    }
  }
}

TEST_P(Kernels, SumTheLongestRun) {
  constexpr std::uint32_t kWidth = 65536;
  Row row{std::make_unique<std::uint8_t[]>(kWidth), {}, {}, kWidth};
  std::fill_n(row.pixels.get(), kWidth, std::uint8_t{255});
  row.limit.assign(kWidth + kLimitPadding, 0);
  row.coarse.assign(kWidth / kCoarsePixels, 0);
  std::vector<std::uint32_t> edges(edges_needed(kWidth));
  ASSERT_EQ(GetParam().scan(row.pixels.get(), row.limit.data(), row.limit.data(), row.coarse.data(), kWidth,
                            edges.data()),
            1u);
  RunSums s{};
  GetParam().measure(row.pixels.get(), row.limit.data(), kWidth, edges.data(), 1, &s);
  const std::uint64_t n = kWidth;
  EXPECT_EQ(s.sum, 255 * n);
  EXPECT_EQ(s.w, 255 * n);
  EXPECT_EQ(s.wi, 255 * (n * (n - 1) / 2));
  EXPECT_EQ(s.wii, 255 * ((n - 1) * n * (2 * n - 1) / 6));
}

TEST_P(Kernels, AgreeOnEveryPairOfValueAndLimit) {
  for (unsigned limit = 0; limit < 256; ++limit) {
    std::vector<std::uint8_t> pixels(256), limits(256 + kLimitPadding, static_cast<std::uint8_t>(limit));
    for (unsigned v = 0; v < 256; ++v) pixels[v] = static_cast<std::uint8_t>(v);
    const auto coarse = static_cast<std::uint8_t>(limit);
    std::vector<std::uint32_t> edges(edges_needed(256));
    const std::uint32_t runs =
        GetParam().scan(pixels.data(), limits.data(), limits.data(), &coarse, 256, edges.data());
    ASSERT_EQ(runs, limit < 255 ? 1u : 0u);
    if (runs == 1) {
      EXPECT_EQ(edges[0], limit + 1);
      EXPECT_EQ(edges[1], 256u);
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
