// SPDX-License-Identifier: MIT
// The two loops that touch pixels, in every instruction set that this CPU has.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "gpu/cpu/blob_moments.hpp"

namespace glint::gpu {

/// Pixels that share one byte of the coarse limit image.
inline constexpr std::uint32_t kCoarsePixels = 256;

/// A pixel's position is y * position_stride(width) + x. Rows of the limit image start at multiples of that:
/// on cache lines, and at least 64 bytes, all 255, may be read behind the last pixel of a row. So
/// there is always a dark position between two rows. Positions are below 2^25 for all images that
/// check_set_up() allows.
constexpr std::uint32_t position_stride(std::uint32_t width_px) noexcept { return (width_px / 64 + 2) * 64; }

/// The row that a position lies in, without a division: 2^42 / stride, rounded up, is wrong by less than
/// stride <= 2^17 / 2^42, too little to reach the next row for positions below 2^25.
class RowOfPosition {
 public:
  explicit RowOfPosition(std::uint32_t width_px) noexcept
      : factor_(((std::uint64_t{1} << 42) + position_stride(width_px) - 1) / position_stride(width_px)) {}
  std::uint32_t operator()(std::uint32_t position) const noexcept {
    return static_cast<std::uint32_t>((position * factor_) >> 42);
  }

 private:
  std::uint64_t factor_;
};

/// An image and the limits of its camera.
struct Rows {
  const std::uint8_t* pixels;
  const std::uint8_t* limit;
  const std::uint8_t* coarse;  ///< the least limit of every kCoarsePixels pixels of a row
  std::size_t pixels_stride, coarse_stride;
  std::uint32_t width;
};

/// A run: bright pixels side by side in one row, at the positions begin <= p < end.
struct PixelRun {
  std::uint32_t begin, end;
};

/// Kernels look at about so many pixels at once, from the first bright row on, and at so many groups of 64
/// pixels that may be bright: many, so that few loops end; few, so that all stays in the first cache.
inline constexpr std::uint32_t kPixelsAtOnce = 4096, kGroupsAtOnce = 64;

/// Most runs that are found at once: the last row may bring as many groups as it has.
constexpr std::uint32_t most_runs_found(std::uint32_t width_px) noexcept {
  return 32 * (kGroupsAtOnce + (width_px + 63) / 64);
}

struct FoundRuns {
  std::uint32_t y;     ///< first row that was not looked at
  std::uint32_t runs;  ///< how many were written
};

/// Looks at rows from y on, not beyond y_end, and writes the runs of the first bright ones from the top left
/// to the bottom right. `runs` has room for most_runs_found(width) + 2: two edges are written at a time.
/// Where no pixel is above the coarse limit, the limit image is not read at all. Nothing is read behind the
/// last pixel of a row.
using FindRuns = FoundRuns (*)(const Rows& rows, std::uint32_t y, std::uint32_t y_end,
                               PixelRun* runs) noexcept;
/// The moments of each of `count` runs, as if each was a blob.
using MeasureRuns = void (*)(const Rows& rows, const PixelRun* runs, std::uint32_t count,
                             BlobMoments* moments) noexcept;

struct RowKernels {
  const char* name;
  FindRuns find;
  MeasureRuns measure;
};

/// What this CPU can run, best first; the last one is plain C++ and always there.
std::span<const RowKernels> row_kernels() noexcept;

/// x86 only: empty where the CPU or the compiler is another one.
std::span<const RowKernels> x86_row_kernels() noexcept;

}  // namespace glint::gpu
