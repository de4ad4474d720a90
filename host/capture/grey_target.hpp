// SPDX-License-Identifier: MIT
// Where a decoder writes its grey pixels.
#pragma once

#include <cstddef>
#include <cstdint>

#include "host/frames/frame_pool.hpp"

namespace glint {

/// Borrowed: size.height_px rows of stride_bytes.
struct GreyTarget {
  std::uint8_t* pixels = nullptr;
  std::size_t stride_bytes = 0;
  FrameSize size;
};

}  // namespace glint
