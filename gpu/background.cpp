// SPDX-License-Identifier: MIT
// Median over time plus margin.
#include "gpu/background.hpp"

#include <algorithm>
#include <array>
#include <cstring>

namespace glint::gpu {
namespace {

constexpr std::size_t kChunk = 4096;  // pixels at a time, so that all counters stay in the first cache

/// The rank-th largest value over time of each of `count` pixels from `first` on, found bit by bit from
/// the top: a value is at least v if `rank` frames are at least v.
void ranked_values(const std::vector<std::vector<std::uint8_t>>& frames, std::size_t first, std::size_t count,
                   std::size_t rank, std::array<std::uint8_t, kChunk>& value) {
  std::array<std::uint8_t, kChunk> trial;
  std::array<std::uint32_t, kChunk> at_least;
  value.fill(0);
  for (unsigned bit = 128; bit != 0; bit >>= 1) {
    for (std::size_t i = 0; i < count; ++i) {
      trial[i] = static_cast<std::uint8_t>(value[i] | bit);
      at_least[i] = 0;
    }
    for (const auto& frame : frames) {
      const std::uint8_t* pixels = frame.data() + first;
      for (std::size_t i = 0; i < count; ++i) at_least[i] += pixels[i] >= trial[i] ? 1u : 0u;
    }
    for (std::size_t i = 0; i < count; ++i) value[i] = at_least[i] >= rank ? trial[i] : value[i];
  }
}

}  // namespace

void BackgroundLearner::add(const ImageView& frame) {
  if (frame.pixels == nullptr || frame.width_px == 0 || frame.height_px == 0 ||
      frame.stride_bytes < frame.width_px) {
    throw Error("background: a frame without pixels cannot be learnt from; skip missing frames");
  }
  if (!frames_.empty() && (frame.width_px != width_px_ || frame.height_px != height_px_)) {
    throw Error("background: a frame of " + std::to_string(frame.width_px) + "x" +
                std::to_string(frame.height_px) + " px among frames of " + std::to_string(width_px_) + "x" +
                std::to_string(height_px_) + " px; give frames of one camera only");
  }
  std::vector<std::uint8_t> copy(std::size_t{frame.width_px} * frame.height_px);
  for (std::size_t y = 0; y < frame.height_px; ++y) {
    std::memcpy(copy.data() + y * frame.width_px, frame.pixels + y * frame.stride_bytes, frame.width_px);
  }
  frames_.push_back(std::move(copy));
  width_px_ = frame.width_px;
  height_px_ = frame.height_px;
}

std::vector<std::uint8_t> BackgroundLearner::median() const {
  if (frames_.empty()) throw Error("background: no frames to learn from; add at least one per camera");
  const std::size_t pixels = frames_.front().size(), n = frames_.size();
  std::vector<std::uint8_t> result(pixels);
  std::array<std::uint8_t, kChunk> lower, upper;
  for (std::size_t first = 0; first < pixels; first += kChunk) {
    const std::size_t count = std::min(kChunk, pixels - first);
    ranked_values(frames_, first, count, n / 2 + 1, lower);
    if (n % 2 == 0) {
      ranked_values(frames_, first, count, n / 2, upper);
    } else {
      upper = lower;
    }
    for (std::size_t i = 0; i < count; ++i) {
      const unsigned median = (unsigned{lower[i]} + unsigned{upper[i]}) / 2;
      result[first + i] = static_cast<std::uint8_t>(median);
    }
  }
  return result;
}

Background BackgroundLearner::learn(unsigned margin) const {
  Background learnt{median(), {}};
  learnt.mean = mean_near(learnt.limit, margin);
  for (std::uint8_t& value : learnt.limit)
    value = static_cast<std::uint8_t>(std::min(255u, value + std::min(margin, 255u)));
  return learnt;
}

std::vector<std::uint16_t> BackgroundLearner::mean_near(const std::vector<std::uint8_t>& middle,
                                                        unsigned margin) const {
  std::vector<std::uint16_t> result(middle.size());
  const int most = static_cast<int>(std::min(margin, 255u));
  std::array<std::uint32_t, kChunk> sum, count;
  for (std::size_t first = 0; first < middle.size(); first += kChunk) {
    const std::size_t pixels = std::min(kChunk, middle.size() - first);
    sum.fill(0);
    count.fill(0);
    for (const auto& frame : frames_) {
      for (std::size_t i = 0; i < pixels; ++i) {
        const int value = frame[first + i], off = value - int{middle[first + i]};
        const bool usual = off <= most && off >= -most;
        sum[i] += usual ? static_cast<std::uint32_t>(value) : 0u;
        count[i] += usual ? 1u : 0u;
      }
    }
    for (std::size_t i = 0; i < pixels; ++i) {
      // The mean of the middle two may be far from both.
      const std::uint32_t steps = count[i] == 0
                                      ? kBackgroundStepsPerGrey * middle[first + i]
                                      : (kBackgroundStepsPerGrey * sum[i] + count[i] / 2) / count[i];
      result[first + i] = static_cast<std::uint16_t>(steps);
    }
  }
  return result;
}

std::vector<std::uint8_t> flat_limit(std::uint32_t width_px, std::uint32_t height_px, unsigned threshold) {
  return std::vector<std::uint8_t>(std::size_t{width_px} * height_px,
                                   static_cast<std::uint8_t>(std::min(threshold, 255u)));
}

}  // namespace glint::gpu
