// SPDX-License-Identifier: MIT
// Identities and time that cannot be mixed up.
#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>

namespace glint {

using Timestamp = std::chrono::steady_clock::time_point;  ///< CLOCK_MONOTONIC, as V4L2 stamps

enum class CameraId : std::uint8_t {};    ///< index into the rig; not a /dev number
enum class TriggerNo : std::uint64_t {};  ///< exposure of the rig, counted from the start of the source
enum class TrackId : std::uint32_t {};    ///< never reused within a run; 0 is no track

constexpr std::size_t index(CameraId id) noexcept { return static_cast<std::size_t>(id); }
constexpr std::uint64_t number(TriggerNo no) noexcept { return static_cast<std::uint64_t>(no); }
constexpr std::uint32_t number(TrackId id) noexcept { return static_cast<std::uint32_t>(id); }

/// Seconds between two time stamps, negative if `to` is earlier.
inline double seconds_between(Timestamp from, Timestamp to) noexcept {
  return std::chrono::duration<double>(to - from).count();
}

}  // namespace glint
