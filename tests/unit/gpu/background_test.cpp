// SPDX-License-Identifier: MIT
// Median over time, margin, saturation.
#include "gpu/background.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <random>
#include <vector>

namespace glint::gpu {
namespace {

ImageView view(const std::vector<std::uint8_t>& pixels, std::uint32_t width, std::uint32_t height) {
  return {pixels.data(), width, height, width, PixelFormat::Grey8};
}

TEST(Background, IsTheMedianPlusMargin) {
  std::mt19937 random(3);
  constexpr std::uint32_t kWidth = 131, kHeight = 67;  // more than one chunk, and not a whole number of them
  for (std::size_t frames = 1; frames <= 9; ++frames) {
    BackgroundLearner learner;
    std::vector<std::vector<std::uint8_t>> images(frames, std::vector<std::uint8_t>(kWidth * kHeight));
    for (auto& image : images) {
      for (auto& pixel : image) pixel = static_cast<std::uint8_t>(random());
      learner.add(view(image, kWidth, kHeight));
    }
    EXPECT_EQ(learner.frames(), frames);
    const std::vector<std::uint8_t> limit = learner.learn(40).limit;
    ASSERT_EQ(limit.size(), kWidth * kHeight);
    for (std::size_t i = 0; i < limit.size(); ++i) {
      std::vector<unsigned> values;
      for (const auto& image : images) values.push_back(image[i]);
      std::sort(values.begin(), values.end());
      const unsigned median =
          frames % 2 == 1 ? values[frames / 2] : (values[frames / 2 - 1] + values[frames / 2]) / 2;
      ASSERT_EQ(limit[i], std::min(255u, median + 40)) << frames << " frames";
    }
  }
}

TEST(Background, MeanIsFinerThanAGreyLevel) {
  constexpr std::uint32_t kWidth = 97, kHeight = 59;  // more than one chunk
  BackgroundLearner learner;
  for (unsigned frame = 0; frame < 8; ++frame) {
    std::vector<std::uint8_t> image(kWidth * kHeight);
    // Pixel i is one grey brighter in i % 9 of the 8 frames.
    for (std::size_t i = 0; i < image.size(); ++i)
      image[i] = static_cast<std::uint8_t>(10 + i % 7 + (frame < i % 9 ? 1 : 0));
    learner.add(view(image, kWidth, kHeight));
  }
  const std::vector<std::uint16_t> mean = learner.learn(3).mean;
  ASSERT_EQ(mean.size(), kWidth * kHeight);
  for (std::size_t i = 0; i < mean.size(); ++i)
    ASSERT_EQ(mean[i], kBackgroundStepsPerGrey * (10 + i % 7) + kBackgroundStepsPerGrey / 8 * (i % 9));
}

TEST(Background, WhatPassesDoesNotCountInTheMean) {
  BackgroundLearner learner;
  for (std::size_t t = 0; t < 5; ++t) {
    std::vector<std::uint8_t> image(6, 10);
    image[t] = 250;  // a marker that moves
    learner.add(view(image, 6, 1));
  }
  EXPECT_EQ(learner.learn(12).mean, std::vector<std::uint16_t>(6, 10 * kBackgroundStepsPerGrey));
}

TEST(Background, TheMiddleOfTwoThatAreFarApartIsTheMean) {
  BackgroundLearner learner;
  for (const std::uint8_t grey : {std::uint8_t{0}, std::uint8_t{200}})
    learner.add(view(std::vector<std::uint8_t>(1, grey), 1, 1));
  EXPECT_EQ(learner.learn(12).mean, std::vector<std::uint16_t>(1, 100 * kBackgroundStepsPerGrey));
}

TEST(Background, WhatMovesLeavesNoHoleAndWhatStandsIsMasked) {
  BackgroundLearner learner;
  for (std::size_t t = 0; t < 5; ++t) {
    std::vector<std::uint8_t> image(16, 10);
    image[t] = 250;   // a marker that moves
    image[12] = 220;  // a lamp
    learner.add(view(image, 16, 1));
  }
  const std::vector<std::uint8_t> limit = learner.learn(40).limit;
  for (std::size_t x = 0; x < 16; ++x) EXPECT_EQ(limit[x], x == 12 ? 255 : 50) << x;
}

TEST(Background, ReadsRowsByStride) {
  const std::vector<std::uint8_t> pixels = {1, 2, 99, 3, 4, 99};
  BackgroundLearner learner;
  learner.add({pixels.data(), 2, 2, 3, PixelFormat::Grey8});
  EXPECT_EQ(learner.learn(0).limit, (std::vector<std::uint8_t>{1, 2, 3, 4}));
}

TEST(Background, RefusesWhatItCannotLearnFrom) {
  BackgroundLearner learner;
  EXPECT_THROW((void)learner.learn(1), Error);
  EXPECT_THROW(learner.add({}), Error);
  const std::vector<std::uint8_t> pixels(12, 7);
  learner.add(view(pixels, 4, 3));
  EXPECT_THROW(learner.add(view(pixels, 3, 4)), Error);
  EXPECT_EQ(learner.frames(), 1u);
}

TEST(Background, FlatLimit) {
  EXPECT_EQ(flat_limit(3, 2, 40), std::vector<std::uint8_t>(6, 40));
  EXPECT_EQ(flat_limit(1, 1, 1000), std::vector<std::uint8_t>(1, 255));
}

}  // namespace
}  // namespace glint::gpu
