// SPDX-License-Identifier: MIT
// Blocks of a JPEG out of its bits. All in the class, so that a loop over blocks keeps it in registers.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <span>

#include "host/capture/jpeg/entropy_bits.hpp"
#include "host/capture/jpeg/huffman_table.hpp"

namespace glint {

/// Places of a block's numbers, and those behind it where codes may lead, the end of the block among them:
/// nothing is there.
inline constexpr std::size_t kJpegPlaces = 64 + HuffmanTable::kEndOfBlock;

/// What is the same for all blocks of one component.
struct JpegBlockTables {
  const HuffmanTable* dc = nullptr;
  const HuffmanTable* ac = nullptr;
  std::array<std::int32_t, kJpegPlaces> weight{};  ///< of a number's size, by its place in the file; 0 beyond
};

/// One or two numbers of a block, without its mean.
struct JpegNumbers {
  HuffmanPair pair;
  std::uint32_t place = 0;  ///< of the number before the first

  std::size_t first_place() const noexcept { return place + pair.first_advance; }
  std::size_t second_place() const noexcept { return first_place() + pair.second_advance; }
};

class JpegBlockReader {
 public:
  /// `tables` is borrowed.
  explicit JpegBlockReader(const JpegBlockTables& tables) noexcept : tables_(&tables) {}

  /// The next block, as far as it is without fault. `numbers` has room for kMostNumbers.
  [[nodiscard]] bool read(EntropyBits& bits, JpegNumbers* numbers) noexcept {
    const HuffmanStep difference = tables_->dc->next(bits.window());
    if (difference.bits == 0) [[unlikely]]
      return false;
    bits.skip(difference.bits);
    mean_ += difference.value;
    weight_ = 0;
    JpegNumbers* next = numbers;
    std::uint32_t place = 0;
    while (place < kLast) {
      const HuffmanPair& pair = tables_->ac->next_pair(bits.window());
      const std::uint32_t first = place + pair.first_advance;
      if (first < kLast) [[likely]] {
        *next++ = {pair, place};
        const std::uint32_t second = first + pair.second_advance;
        weight_ += std::abs(std::int32_t{pair.first}) * tables_->weight[first] +
                   std::abs(std::int32_t{pair.second}) * tables_->weight[second];
        bits.skip(pair.bits);
        place = second;
        continue;
      }
      // Not two, and perhaps not to be told at one look.
      const HuffmanStep one = tables_->ac->next(bits.window());
      if (one.bits == 0) return false;
      bits.skip(one.bits);
      *next++ = {{one.bits, one.advance, 0, one.value, 0}, place};
      place += one.advance;
      weight_ += std::abs(std::int32_t{one.value}) * tables_->weight[place];
    }
    count_ = static_cast<std::size_t>(next - numbers);
    return !bits.overrun() && (place == kLast || place >= HuffmanTable::kEndOfBlock);
  }

  /// Forgets the mean of the block before.
  void restart() noexcept { mean_ = 0; }
  /// Of the last block: its mean, quantised; sum over its numbers of size times weight; how many JpegNumbers.
  std::int32_t mean() const noexcept { return mean_; }
  std::int32_t weight() const noexcept { return weight_; }
  std::size_t count() const noexcept { return count_; }

  static constexpr std::size_t kMostNumbers = 64;

 private:
  static constexpr std::uint32_t kLast = 63;  // place
  const JpegBlockTables* tables_;
  std::int32_t mean_ = 0, weight_ = 0;
  std::size_t count_ = 0;
};

}  // namespace glint
