// SPDX-License-Identifier: MIT
// JPEGs of scenes that are mostly dark: only what can be bright is turned into pixels.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "host/capture/grey_target.hpp"
#include "host/capture/jpeg/block_reader.hpp"
#include "host/capture/jpeg/block_transform.hpp"
#include "host/capture/jpeg/jpeg_layout.hpp"
#include "host/capture/jpeg/standard_codes.hpp"

namespace glint {

/// Every code of the file is read, as there is no other way to find the next one. But a block of 8x8 pixels
/// is transformed only if one of its pixels can be above its limit: its mean plus the sum of what each
/// coefficient can add at most says so. Other blocks get their mean, which is not above the limit either.
/// So pixels above the limit are those of FullJpegDecoder, to the last digit, and no other pixel is above it.
///
/// Only for pictures without fault of the kinds that cameras send: baseline, one scan, grey or colour with
/// brightness in full resolution. Thread-bound; decode() allocates only for files of more bytes than the
/// picture has pixels.
class BrightJpegDecoder {
 public:
  /// Throws Error.
  BrightJpegDecoder();

  /// Pixels of pictures of this size matter only where they are above `limit` (rows without gaps, borrowed
  /// for the call). Throws std::bad_alloc.
  void set_limit(std::span<const std::uint8_t> limit, FrameSize size);
  /// There is a limit for pictures of this size.
  bool has_limit(FrameSize size) const noexcept {
    return !darkest_limit_.empty() && size.width_px == size_.width_px && size.height_px == size_.height_px;
  }

  /// False: damaged, or of a kind or size that this is not for; the target then holds nothing of use, and
  /// FullJpegDecoder may know better what it is. Only after set_limit().
  [[nodiscard]] bool decode(std::span<const std::byte> jpeg, const GreyTarget& target) noexcept;

  /// Blocks of all pictures so far, and those of them that were transformed.
  std::uint64_t blocks() const noexcept { return blocks_; }
  std::uint64_t transformed() const noexcept { return transformed_; }

 private:
  struct BrightBlock {
    std::uint32_t column, row;
    std::array<std::uint8_t, 64> pixels;
  };
  // Rows of blocks in one unit at most.
  static constexpr std::size_t kMostDown = 4;

  bool prepare() noexcept;
  bool decode_units(const GreyTarget& target) noexcept;
  bool stays_below(std::int32_t room, std::int32_t sum_of_most,
                   std::span<const JpegNumbers> numbers) const noexcept;
  bool transform(std::uint32_t column, std::uint32_t row, std::int32_t mean,
                 std::span<const JpegNumbers> numbers) noexcept;
  void put_means(std::uint32_t row, const std::uint8_t* means, const GreyTarget& target) noexcept;
  void put_bright(const GreyTarget& target) noexcept;

  FrameSize size_;
  std::uint32_t columns_ = 0, rows_ = 0;     // of blocks
  std::vector<std::int32_t> darkest_limit_;  // of each block, less 128, in kUnits
  StandardCodes standard_;
  std::array<HuffmanTable, JpegLayout::kTables> dc_, ac_;
  JpegLayout layout_;
  EntropyData data_;
  /// Of brightness the weight is what a coefficient of 1 adds to a pixel at most, in kUnits.
  std::array<JpegBlockTables, JpegLayout::kMostComponents> tables_;
  std::array<std::int32_t, 64> step_{};  // of brightness, in the order of the file
  JpegBlock block_;                      // zeros between blocks
  // Of the row of units under way: what its blocks' means are, and those that are more than that.
  std::vector<std::uint8_t> means_;
  std::vector<BrightBlock> bright_;
  std::vector<std::uint8_t> line_;  // of pixels
  std::uint64_t blocks_ = 0, transformed_ = 0;
};

}  // namespace glint
