// SPDX-License-Identifier: MIT
// Canonical codes: those of one length follow each other, and are numerically smaller than all longer ones.
#include "host/capture/jpeg/huffman_table.hpp"

namespace glint {
namespace {

constexpr unsigned kLongest = 16;
constexpr unsigned kMostDcBits = 11, kMostAcBits = 10;  // of a number, in 8-bit pictures
constexpr unsigned kSixteenZeros = 0xf0, kEnd = 0x00;

/// Is it a symbol that means something? Upper half: zeros to pass over; lower half: bits of the number.
bool known(std::uint8_t symbol, HuffmanTable::Kind kind) noexcept {
  if (kind == HuffmanTable::Kind::Dc) return symbol <= kMostDcBits;
  const unsigned bits = symbol & 0xfu;
  return bits == 0 ? symbol == kEnd || symbol == kSixteenZeros : bits <= kMostAcBits;
}

}  // namespace

/// The code is the first `length` bits of the window, its number follows.
HuffmanStep HuffmanTable::step_of(unsigned length, std::uint8_t symbol, std::uint64_t window) const noexcept {
  const unsigned bits = symbol & 0xfu;
  HuffmanStep step;
  step.bits = static_cast<std::uint8_t>(length + bits);
  step.advance =
      kind_ == Kind::Ac && symbol == kEnd ? kEndOfBlock : static_cast<std::uint8_t>((symbol >> 4) + 1);
  if (bits != 0) {
    // A number whose first bit is 0 is negative: the magnitude's complement.
    const auto raw = static_cast<std::int32_t>((window << length) >> (64 - bits));
    step.value = static_cast<std::int16_t>(raw < (1 << (bits - 1)) ? raw - (1 << bits) + 1 : raw);
  }
  return step;
}

bool HuffmanTable::set(const HuffmanCodes& codes, Kind kind) noexcept {
  if (set_ && kind_ == kind && codes_ == codes) return true;
  set_ = false;
  codes_ = codes;
  kind_ = kind;
  std::uint32_t code = 0;
  std::size_t symbols = 0;
  for (unsigned length = 1; length <= kLongest; ++length) {
    code <<= 1;
    symbol_at_[length] = static_cast<std::int32_t>(symbols) - static_cast<std::int32_t>(code);
    for (unsigned n = 0; n < codes.of_length[length - 1]; ++n, ++code, ++symbols) {
      // The code of ones alone is none; this also keeps `symbols` within its array.
      if (code + 1 >= (1u << length) || symbols >= codes.symbols.size() ||
          !known(codes.symbols[symbols], kind))
        return false;
    }
    end_[length] = code << (kLongest - length);
  }
  for (std::size_t n = 0; n < steps_.size(); ++n) {
    const std::uint64_t window = std::uint64_t{n} << (64 - kPeek);
    const HuffmanStep step = search(window);
    steps_[n] = step.bits <= kPeek ? step : HuffmanStep{};
  }
  for (std::size_t n = 0; n < pairs_.size(); ++n) {
    const HuffmanStep first = steps_[n];
    pairs_[n] = {first.bits, first.bits == 0 ? kEndOfBlock : first.advance, 0, first.value, 0};
    if (first.bits == 0 || first.advance == kEndOfBlock) continue;
    // What is not known yet reads as zeros: only codes that do without it count.
    const HuffmanStep second = steps_[(n << first.bits) % steps_.size()];
    const unsigned bits = unsigned{first.bits} + second.bits;
    if (second.bits == 0 || bits > kPeek) continue;
    pairs_[n] = {static_cast<std::uint8_t>(bits), first.advance, second.advance, first.value, second.value};
  }
  set_ = true;
  return true;
}

HuffmanStep HuffmanTable::search(std::uint64_t window) const noexcept {
  const auto first = static_cast<std::uint32_t>(window >> (64 - kLongest));
  for (unsigned length = 1; length <= kLongest; ++length) {
    if (first >= end_[length]) continue;
    const auto index = symbol_at_[length] + static_cast<std::int32_t>(first >> (kLongest - length));
    return step_of(length, codes_.symbols[static_cast<std::size_t>(index)], window);
  }
  return {};
}

}  // namespace glint
