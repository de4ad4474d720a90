// SPDX-License-Identifier: MIT
// The coded blocks of a JPEG as a stream of bits.
#pragma once

#include <cstddef>
#include <cstdint>
#include <cstring>
#include <span>
#include <vector>

namespace glint {

/// Coded data without stuffed bytes, cut where restart markers stood. Thread-bound; allocates only for more
/// data than ever before.
class EntropyData {
 public:
  /// Makes room for so many bytes. Throws std::bad_alloc.
  void reserve(std::size_t bytes);
  /// What lies between `data`'s start and the end-of-image marker. False if anything but restart markers in
  /// their order comes before that marker, if it is missing, if there are too many, or no memory.
  [[nodiscard]] bool read(std::span<const std::uint8_t> data) noexcept;

  std::size_t parts() const noexcept { return ends_.size(); }
  /// Bytes of one part, kBehind readable ones behind them.
  std::span<const std::uint8_t> part(std::size_t n) const noexcept {
    const std::size_t begin = n == 0 ? 0 : ends_[n - 1] + kBehind;
    return {bytes_.data() + begin, ends_[n] - begin};
  }
  /// More than one block can take: 64 codes and numbers of at most 27 bits, and a reader's look ahead.
  static constexpr std::size_t kBehind = 256;

 private:
  // A marker for each row of blocks is usual where there are any.
  static constexpr std::size_t kMostParts = 512;
  std::vector<std::uint8_t> bytes_;  // parts, each with kBehind zeros behind it
  std::vector<std::size_t> ends_;
};

/// Reads on without checks for at most one block; overrun() then says whether it went too far.
class EntropyBits {
 public:
  explicit EntropyBits(std::span<const std::uint8_t> part) noexcept
      : next_(part.data()), end_(part.data() + part.size()) {}

  /// At least 32 bits, the next one at the top.
  std::uint64_t window() noexcept {
    if (count_ < 32) fill();
    return window_;
  }
  void skip(unsigned bits) noexcept {
    window_ <<= bits;
    count_ -= bits;
  }
  /// Bits behind the end were taken.
  bool overrun() const noexcept { return left() < 0; }
  /// All is taken but what fills up the last byte.
  bool finished() const noexcept { return left() >= 0 && left() < 8; }

 private:
  // Bits beyond count_ are the file's too; reading them again changes nothing.
  void fill() noexcept {
    std::uint64_t bytes = 0;
    std::memcpy(&bytes, next_, sizeof bytes);
    window_ |= __builtin_bswap64(bytes) >> count_;
    next_ += (63 - count_) / 8;
    count_ |= 56;
  }
  std::ptrdiff_t left() const noexcept { return (end_ - next_) * 8 + static_cast<std::ptrdiff_t>(count_); }

  std::uint64_t window_ = 0;
  unsigned count_ = 0;
  const std::uint8_t* next_;
  const std::uint8_t* end_;
};

}  // namespace glint
