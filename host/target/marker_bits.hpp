// SPDX-License-Identifier: MIT
// The dictionaries of ArUco and AprilTag markers: names, sizes, and what each marker looks like.
#pragma once

#include <cstdint>
#include <string_view>
#include <vector>

namespace glint {

/// OpenCV's name without its DICT_, from one with or without it in capitals or not; empty: no such
/// dictionary. Needs no OpenCV.
std::string_view dictionary_name(std::string_view typed);
/// Number of markers in a dictionary; 0: no such dictionary. Needs no OpenCV.
std::uint32_t markers_in(std::string_view dictionary);

/// One marker with its black frame, one cell wide: side * side cells, row by row.
struct MarkerBits {
  std::uint32_t side = 0;
  std::vector<bool> black;
};
/// From OpenCV's dictionaries; throws Error where glint was built without OpenCV.
MarkerBits marker_bits(std::string_view dictionary, std::uint32_t id);

}  // namespace glint
