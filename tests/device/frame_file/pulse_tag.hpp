// SPDX-License-Identifier: MIT
// The pulse that a picture shows, written into the picture: the truth that tests compare with. No program
// under test looks at it.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

namespace glint::device {

/// The JPEG with the pulse in a comment after its first marker, which decoders skip.
std::vector<std::uint8_t> with_pulse_comment(std::span<const std::uint8_t> jpeg, std::uint64_t pulse);
std::optional<std::uint64_t> pulse_of_comment(std::span<const std::uint8_t> jpeg) noexcept;
/// Whether the JPEG ends as it should. Drivers may pad with zeros.
bool ends_whole(std::span<const std::uint8_t> jpeg) noexcept;

inline constexpr std::size_t kGreyTagPixels = 16;
/// In the first 16 pixels, four bits each, too dark for any threshold.
void put_pulse(std::span<std::uint8_t, kGreyTagPixels> pixels, std::uint64_t pulse) noexcept;
std::uint64_t get_pulse(std::span<const std::uint8_t, kGreyTagPixels> pixels) noexcept;

}  // namespace glint::device
