// SPDX-License-Identifier: MIT
// Which frames go wrong, and how: the same answer whoever asks.
#pragma once

#include <cstdint>

#include "host/sim/options.hpp"

namespace glint::sim {

enum class Fate : std::uint8_t {
  Fine,
  Dropped,     ///< never arrives
  Late,        ///< arrives after its set was closed
  Duplicated,  ///< the image before it arrives again in its place
};

/// Independent for each camera and tick. A frame is only replaced by the one before it if that one was fine.
Fate fate(const SimOptions& options, std::uint32_t camera, std::uint64_t tick) noexcept;

}  // namespace glint::sim
