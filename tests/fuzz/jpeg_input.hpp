// SPDX-License-Identifier: MIT
// What the bytes of fuzz_jpeg mean: how a picture is to be decoded, then the picture.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "host/frames/frame_pool.hpp"

namespace glint::test {

/// Sizes that the target can have, with and without whole blocks, from one pixel to several units.
inline constexpr std::array<FrameSize, 6> kJpegSizes{
    {{64, 48}, {1, 1}, {8, 8}, {35, 21}, {130, 17}, {16, 72}}};

struct JpegInput {
  std::uint8_t size = 0;   ///< index into kJpegSizes, wraps around
  std::uint8_t limit = 0;  ///< of every pixel, at least
  std::uint8_t rise = 0;   ///< more limit from pixel to pixel, until it wraps around
  std::uint8_t gap = 0;    ///< bytes between rows of the target, wraps around at 16
};
inline constexpr std::size_t kJpegInputBytes = 4;  // each a byte, in that order

}  // namespace glint::test
