// SPDX-License-Identifier: MIT
// What became of every frame that a pulse should have brought.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace glint {

/// Exactly one of these for every pulse and camera.
enum class FrameFate : std::uint8_t {
  Used,        ///< in the frame set that was handed on
  Late,        ///< arrived whole after its set had gone on without it
  Skipped,     ///< arrived, but its whole set was dropped by us, because the consumer was behind
  LostByHost,  ///< the driver counted it and had no buffer or bandwidth for it: a gap in the sequence numbers
  LostByCamera,  ///< no frame, and no gap: never sent, or the camera was silent or gone
  Corrupt,       ///< arrived damaged, in time or not
  Dark,          ///< arrived whole; the light was off on purpose in this pulse
};
inline constexpr std::size_t kFrameFates = 7;

struct CameraLedger {
  std::array<std::uint64_t, kFrameFates> count{};
  /// Not entries but frames given back unseen: their pulse had one already (duplicates); their time stamp
  /// fits no pulse for certain, so that their pulse stands as lost by the camera (unplaced); they came before
  /// pulses could be told apart, and belong to no pulse that is counted (warm_up).
  std::uint64_t duplicates = 0, unplaced = 0, warm_up = 0;

  std::uint64_t operator[](FrameFate fate) const noexcept { return count[static_cast<std::size_t>(fate)]; }
  std::uint64_t& operator[](FrameFate fate) noexcept { return count[static_cast<std::size_t>(fate)]; }
  /// Sum of the entries.
  std::uint64_t total() const noexcept;
};

/// pulses == cameras[i].total() for every camera, at any time between two calls of the assembler.
struct Ledger {
  std::uint64_t pulses = 0;
  std::vector<CameraLedger> cameras;

  bool balanced() const noexcept;
};

}  // namespace glint
