// SPDX-License-Identifier: MIT
// The two loops that touch pixels, in every instruction set that this CPU has.
#pragma once

#include <bit>
#include <cstdint>
#include <span>

namespace glint::gpu {

/// Runs (bright pixels side by side in one row) are kept as edges: run r is the pixels
/// edges[2 r] <= x < edges[2 r + 1].
constexpr std::uint32_t edges_needed(std::uint32_t width_px) noexcept {
  return width_px / 2 * 2 + 2 + 2;  // the last two: the kernels write two edges at a time
}

/// Sums over the pixels of a run; w = value - limit, i = x - first x.
struct RunSums {
  std::uint64_t wi, wii;
  std::uint32_t sum, w, peak;
};

/// Pixels that share one byte of the row's coarse limit.
inline constexpr std::uint32_t kCoarsePixels = 256;

/// Rows of the limit image start on cache lines, and at least this many bytes, all 255, may be read behind
/// the last pixel of a row.
inline constexpr std::uint32_t kLimitPadding = 64;

/// Finds the runs of a row from left to right, and returns how many. `coarse` is the least limit of
/// every kCoarsePixels pixels: where no pixel is above it, the limit image is not read at all. `edges`
/// has room for edges_needed(width). Nothing is read behind pixels[width - 1]. The limits of the row below
/// are fetched into the cache where this row is bright: blobs go on, and the limit image is read so
/// sparsely that the CPU would not guess it.
using ScanRow = std::uint32_t (*)(const std::uint8_t* pixels, const std::uint8_t* limit,
                                  const std::uint8_t* limit_below, const std::uint8_t* coarse,
                                  std::uint32_t width, std::uint32_t* edges) noexcept;
/// Sums of each of `runs` runs of the row.
using MeasureRuns = void (*)(const std::uint8_t* pixels, const std::uint8_t* limit, std::uint32_t width,
                             const std::uint32_t* edges, std::uint32_t runs, RunSums* sums) noexcept;

struct RowKernels {
  const char* name;
  ScanRow scan;
  MeasureRuns measure;
};

/// What this CPU can run, best first; the last one is plain C++ and always there.
std::span<const RowKernels> row_kernels() noexcept;

/// x86 only: empty where the CPU or the compiler is another one.
std::span<const RowKernels> x86_row_kernels() noexcept;

/// Collects the edges of a row, 64 pixels after 64 pixels.
class EdgeWriter {
 public:
  explicit EdgeWriter(std::uint32_t* edges) noexcept : edges_(edges) {}

  /// The pixels x .. x + 63, lowest bit first; those left out before them are dark.
  [[gnu::always_inline]] void add(std::uint64_t bits, std::uint32_t x) noexcept {
    const std::uint64_t ended = lit_ & static_cast<std::uint64_t>(x != end_);
    edges_[count_] = end_;
    count_ += static_cast<std::uint32_t>(ended);
    lit_ ^= ended;
    std::uint64_t changes = bits ^ ((bits << 1) | lit_);
    lit_ = bits >> 63;
    end_ = x + 64;
    // Most groups have two edges at most: writing two and keeping as many as there are takes no branch that
    // could be guessed wrong.
    const auto count = static_cast<std::uint32_t>(std::popcount(changes));
    edges_[count_] = x + static_cast<std::uint32_t>(std::countr_zero(changes));
    changes &= changes - 1;
    edges_[count_ + 1] = x + static_cast<std::uint32_t>(std::countr_zero(changes));
    if (count > 2) [[unlikely]] {
      std::uint32_t at = count_ + 2;
      for (changes &= changes - 1; changes != 0; changes &= changes - 1) {
        edges_[at++] = x + static_cast<std::uint32_t>(std::countr_zero(changes));
      }
    }
    count_ += count;
  }
  /// The row ends; returns the number of runs.
  [[gnu::always_inline]] std::uint32_t finish() noexcept {
    edges_[count_] = end_;
    return (count_ + static_cast<std::uint32_t>(lit_)) / 2;
  }

 private:
  std::uint32_t* edges_;
  std::uint32_t count_ = 0, end_ = 0;  // end_: behind the pixels added last
  std::uint64_t lit_ = 0;              // 1: the last pixel so far was bright
};

}  // namespace glint::gpu
