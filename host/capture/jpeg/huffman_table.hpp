// SPDX-License-Identifier: MIT
// Huffman codes of a JPEG (ITU-T T.81, annexes C and F), arranged so that one look gives a whole coefficient.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

namespace glint {

/// A table as the file has it: how many codes there are of each length, and what they stand for.
struct HuffmanCodes {
  std::array<std::uint8_t, 16> of_length{};  ///< [0]: codes of one bit
  std::array<std::uint8_t, 256> symbols{};
  bool operator==(const HuffmanCodes&) const = default;
};

/// What the next bits mean: how many zeros to pass over, and the number after them.
struct HuffmanStep {
  std::int16_t value = 0;
  std::uint8_t advance = 0;  ///< to the next number's place: zeros + 1
  std::uint8_t bits = 0;     ///< of code and value together; 0: not a code
};

/// Two of them, where both fit into one look. Else the second has no bits and no value, and does not advance;
/// where not even one fits, the first leads beyond any place.
struct HuffmanPair {
  std::uint8_t bits = 0;  ///< of both
  std::uint8_t first_advance = 0, second_advance = 0;
  std::int16_t first = 0, second = 0;
};

/// Looking up codes whose bits, those of the number included, are at most kPeek; longer ones take a search.
class HuffmanTable {
 public:
  static constexpr unsigned kPeek = 11;
  /// `advance` of the code that ends a block: beyond any place in it.
  static constexpr std::uint8_t kEndOfBlock = 128;
  enum class Kind : std::uint8_t { Dc, Ac };

  /// False if these are no codes: too many of a length, or symbols that a baseline JPEG cannot have. Does
  /// nothing if they are those that it holds already.
  [[nodiscard]] bool set(const HuffmanCodes& codes, Kind kind) noexcept;

  /// window: the next bits of the file, the first at the top; at least 32 are there.
  HuffmanStep next(std::uint64_t window) const noexcept {
    const HuffmanStep step = steps_[window >> (64 - kPeek)];
    if (step.bits != 0) [[likely]]
      return step;
    return search(window);
  }
  /// Likewise, two at once. Of use inside a block: behind its last number the second means something else.
  const HuffmanPair& next_pair(std::uint64_t window) const noexcept { return pairs_[window >> (64 - kPeek)]; }

 private:
  HuffmanStep search(std::uint64_t window) const noexcept;
  HuffmanStep step_of(unsigned length, std::uint8_t symbol, std::uint64_t window) const noexcept;

  std::array<HuffmanStep, std::size_t{1} << kPeek> steps_{};
  std::array<HuffmanPair, std::size_t{1} << kPeek> pairs_{};
  std::array<std::uint32_t, 17> end_{};       // of length n: first code that is longer, as 16 bits
  std::array<std::int32_t, 17> symbol_at_{};  // of length n: index of a symbol minus its code
  HuffmanCodes codes_;
  Kind kind_ = Kind::Dc;
  bool set_ = false;
};

}  // namespace glint
