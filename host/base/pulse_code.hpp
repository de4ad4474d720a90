// SPDX-License-Identifier: MIT
// In which pulses the sync board leaves the light off: one definition for the board and everybody who checks.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>

namespace glint {

/// Pulses, counted from 0, come in groups of `group`; exactly one pulse of each group is dark. With
/// half = group / 2, and all arithmetic on unsigned 32-bit numbers except where 64 is said:
///
///   n      = pulse / group % 256
///   x      = seed + 0x9e3779b9 * (n + 1)
///   x      = (x ^ x >> 16) * 0x85ebca6b
///   x      = (x ^ x >> 13) * 0xc2b2ae35
///   x      = x ^ x >> 16
///   offset = (64-bit x * half) >> 32
///
/// and the pulse is dark if pulse % group == offset. (The mixing is the finalizer of MurmurHash3, Appleby
/// 2011.) Two dark pulses are half + 1 to group + half - 1 pulses apart: never adjacent. The code repeats
/// after 256 groups, so that where in it a rig is can be found from pictures alone.
class PulseCode {
 public:
  static constexpr std::uint32_t kGroups = 256;
  /// With fewer pulses a group, dark ones could be so near that slips by up to 8 would look alike.
  static constexpr std::uint32_t kLeastGroup = 18;
  static constexpr std::uint32_t kMostGroup = 1024;

  /// `group` is clamped to kLeastGroup .. kMostGroup.
  constexpr PulseCode(std::uint32_t seed, std::uint32_t group) noexcept
      : group_(std::clamp(group, kLeastGroup, kMostGroup)) {
    for (std::uint32_t n = 0; n < kGroups; ++n) offset_[n] = offset_of(seed, n, group_ / 2);
  }

  constexpr std::uint32_t group() const noexcept { return group_; }
  /// Pulses after which the code repeats.
  constexpr std::uint64_t length() const noexcept { return std::uint64_t{kGroups} * group_; }
  /// The dark pulse of the group n, 0 .. kGroups - 1, of the first length() pulses.
  constexpr std::uint64_t dark_pulse(std::uint32_t n) const noexcept {
    return std::uint64_t{n} * group_ + offset_[n];
  }
  constexpr bool dark(std::uint64_t pulse) const noexcept {
    return pulse % group_ == offset_[pulse / group_ % kGroups];
  }

  /// `group`, or where that is 0 the recommended one.
  static constexpr std::uint32_t group_for(std::uint32_t group, double rate_hz) noexcept {
    return group != 0 ? group : recommended_group(rate_hz);
  }
  /// Such that less than half a second passes from one dark pulse to the next: a camera that slips has two
  /// within a second. 30 (3.3 % dark) at 90 Hz, 82 (1.2 %) at 250 Hz. Below 53 Hz, kLeastGroup takes longer.
  static constexpr std::uint32_t recommended_group(double rate_hz) noexcept {
    constexpr double kLongestGap_s = 0.5;
    constexpr double kRounding = 1e-6;  // 90 Hz is exactly 30
    const double group = rate_hz * kLongestGap_s / 1.5 + kRounding;
    return static_cast<std::uint32_t>(std::clamp(group, double{kLeastGroup}, double{kMostGroup})) / 2 * 2;
  }

 private:
  static constexpr std::uint16_t offset_of(std::uint32_t seed, std::uint32_t n, std::uint32_t half) noexcept {
    std::uint32_t x = seed + 0x9e3779b9u * (n + 1u);
    x = (x ^ x >> 16) * 0x85ebca6bu;
    x = (x ^ x >> 13) * 0xc2b2ae35u;
    x ^= x >> 16;
    return static_cast<std::uint16_t>(std::uint64_t{x} * half >> 32);
  }

  std::uint32_t group_;
  std::array<std::uint16_t, kGroups> offset_{};
};

}  // namespace glint
