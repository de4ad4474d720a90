// SPDX-License-Identifier: MIT
// Compares a picture's blobs with those of its neighbours.
#include "host/assemble/light_history.hpp"

#include <algorithm>
#include <utility>

namespace glint {
namespace {

constexpr std::uint64_t kFarthest = 4;  // pulses; far less than dark ones are apart

// Chances of a mistake, as logarithms, by the number of blobs: one marker passes behind something for a
// single picture once in twenty times, three together once in ten thousand. Blobs in the dark are rarer:
// stray reflections of another light, or a picture that came twice.
float vanish_by_themselves(std::uint32_t blobs) noexcept {
  return blobs == 1 ? -3.0F : blobs == 2 ? -7.0F : -9.2F;
}
float shine_by_themselves(std::uint32_t blobs) noexcept {
  return blobs == 1 ? -4.6F : blobs == 2 ? -9.2F : -13.8F;
}

}  // namespace

std::optional<LightEvidence> LightHistory::add(std::uint64_t pulse, std::uint32_t blobs) noexcept {
  const Picture before = std::exchange(before_, middle_), at = std::exchange(middle_, {pulse, blobs});
  const bool known = kept_ == 2;
  kept_ = std::min(kept_ + 1, 2U);
  if (!known || at.pulse - before.pulse > kFarthest || pulse - at.pulse > kFarthest) return std::nullopt;
  const std::uint64_t fewer = std::min(before.blobs, blobs), more = std::max(before.blobs, blobs);
  if (fewer > 0 && 4 * std::uint64_t{at.blobs} <= fewer) {
    return LightEvidence{at.pulse, false, vanish_by_themselves(static_cast<std::uint32_t>(fewer))};
  }
  if (more > 0 && 4 * std::uint64_t{at.blobs} >= 3 * more) {
    return LightEvidence{at.pulse, true, shine_by_themselves(at.blobs)};
  }
  return std::nullopt;
}

}  // namespace glint
