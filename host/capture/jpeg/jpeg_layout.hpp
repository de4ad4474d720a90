// SPDX-License-Identifier: MIT
// What the head of a JPEG says (ITU-T T.81, annex B), for those that cameras send.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>

#include "host/capture/jpeg/huffman_table.hpp"
#include "host/frames/frame_pool.hpp"

namespace glint {

struct JpegComponent {
  std::uint8_t id = 0;
  std::uint8_t across = 1, down = 1;  ///< blocks of it in each unit of several components
  std::uint8_t quantizer = 0, dc_table = 0, ac_table = 0;
};

struct JpegLayout {
  static constexpr std::size_t kMostComponents = 3, kTables = 4;
  FrameSize size;
  std::array<JpegComponent, kMostComponents> components{};  ///< the first is brightness
  std::size_t component_count = 0;
  /// Steps of the coefficients in the order of the file.
  std::array<std::optional<std::array<std::uint16_t, 64>>, kTables> quantizers;
  std::array<HuffmanCodes, kTables> dc, ac;
  std::uint32_t restart_interval = 0;  ///< units between restart markers; 0: none
  std::size_t data_at = 0;             ///< where the coded blocks begin
};

/// Reads up to the coded blocks. Huffman tables that the file does not bring stay as they are in `layout`;
/// everything else is set. False: damaged, or of a kind that is not baseline, of one scan, with brightness in
/// full resolution. Never throws, never reads beyond the file.
[[nodiscard]] bool read_layout(std::span<const std::uint8_t> jpeg, JpegLayout& layout) noexcept;

}  // namespace glint
