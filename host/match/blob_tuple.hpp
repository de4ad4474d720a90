// SPDX-License-Identifier: MIT
// Blobs that may be one marker.
#pragma once

#include <array>
#include <cstdint>
#include <span>

#include "host/match/matcher.hpp"

namespace glint {

/// At most one blob per camera, by their numbers in the blob table.
struct BlobTuple {
  std::array<std::uint32_t, kMatchCameras> blobs{};
  std::uint32_t count = 0;
  void add(std::uint32_t blob) noexcept { blobs[count++] = blob; }
  std::span<const std::uint32_t> span() const noexcept { return {blobs.data(), count}; }
};

}  // namespace glint
