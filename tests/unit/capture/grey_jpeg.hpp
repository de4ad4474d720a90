// SPDX-License-Identifier: MIT
// JPEGs as cameras make them.
#pragma once

#include <cstdint>
#include <vector>

namespace glint::test {

/// A dark picture with noise and some bright discs, row by row.
std::vector<std::uint8_t> disc_picture(std::uint32_t width_px, std::uint32_t height_px, unsigned seed);

/// `colour`: 4:2:2, as most USB cameras send even what is grey; else one component.
std::vector<std::uint8_t> jpeg_of(const std::vector<std::uint8_t>& grey, std::uint32_t width_px,
                                  std::uint32_t height_px, int quality, bool colour = false);

/// `sampling`: TurboJPEG's number for it. Colours are not all the same, so that they must be read past.
/// `restarts`: a marker behind each row of units.
std::vector<std::uint8_t> sampled_jpeg_of(const std::vector<std::uint8_t>& grey, std::uint32_t width_px,
                                          std::uint32_t height_px, int quality, int sampling, bool restarts);

/// Without its Huffman tables, as Motion JPEG comes. They must be the standard ones, which jpeg_of()'s are.
std::vector<std::uint8_t> without_huffman_tables(const std::vector<std::uint8_t>& jpeg);

}  // namespace glint::test
