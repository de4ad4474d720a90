// SPDX-License-Identifier: MIT
// Which frames, markers and pixels go wrong, and how: the same answer whoever asks.
#pragma once

#include <cstdint>

#include "host/sim/options.hpp"
#include "host/sim/random.hpp"

namespace glint::sim {

enum class Fate : std::uint8_t {
  Fine,
  Dropped,     ///< never arrives
  Late,        ///< arrives after its set was closed
  Duplicated,  ///< the image before it arrives again in its place
};

/// Independent for each camera and tick. A frame is only replaced by the one before it if that one was fine.
Fate fate(const SimOptions& options, std::uint32_t camera, std::uint64_t tick) noexcept;

/// That marker gives no light in that camera and exposure.
bool missing(const SimOptions& options, std::uint32_t camera, std::uint64_t tick,
             std::uint32_t marker) noexcept;

/// Pixels that light up in one frame, `size_px` by `size_px` from (x_px, y_px) on.
struct Blink {
  int x_px = 0, y_px = 0, size_px = 1;
  std::uint8_t grey = 0;
};

/// The blinks of one frame; the same whenever they are asked for.
class Blinks {
 public:
  static constexpr std::uint32_t kMost = 1000;
  Blinks(const SimOptions& options, std::uint32_t camera, std::uint64_t tick) noexcept;

  std::uint32_t count() const noexcept { return count_; }
  Blink next() noexcept;  ///< to be called count() times

 private:
  Random random_;
  std::uint32_t width_px_, height_px_, count_ = 0;
};

}  // namespace glint::sim
