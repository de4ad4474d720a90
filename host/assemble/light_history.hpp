// SPDX-License-Identifier: MIT
// Whether the light was on in a camera's picture, judged beside the pictures before and after.
#pragma once

#include <cstdint>
#include <optional>

namespace glint {

struct LightEvidence {
  std::uint64_t pulse = 0;
  bool lit = false;
  /// Logarithm of the chance that the picture looks so although the light was off (on, if it looks dark): the
  /// more blobs there are, the less likely is it that all of them vanish, or appear, by themselves.
  float log_mistaken = 0.0F;
};

/// One camera's last pictures. Blobs are counted and not their light added up: a lamp outshines all markers
/// but is one blob.
class LightHistory {
 public:
  /// The next picture. What is said is about the one before it, whose neighbours are now known: dark if it
  /// has at most a quarter of their blobs, lit if it has at least three quarters. Nothing if it is neither,
  /// if a neighbour is more than 4 pulses away, or if a dark one has a neighbour without blobs: dark pulses
  /// come alone, so the markers themselves must be out of sight.
  std::optional<LightEvidence> add(std::uint64_t pulse, std::uint32_t blobs) noexcept;
  void clear() noexcept { kept_ = 0; }

 private:
  struct Picture {
    std::uint64_t pulse = 0;
    std::uint32_t blobs = 0;
  };
  Picture before_, middle_;
  unsigned kept_ = 0;  // of the two; the newest is middle_
};

}  // namespace glint
