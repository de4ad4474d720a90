// SPDX-License-Identifier: MIT
// The row kernels in plain C++, eight pixels in a 64-bit word; and the choice among all kernels.
#include "gpu/cpu/row_kernels.hpp"

#include <algorithm>
#include <array>
#include <cstring>

#include "gpu/cpu/run_writer.hpp"

namespace glint::gpu {
namespace {

constexpr std::uint64_t kHigh = 0x8080808080808080u;

std::uint64_t load8(const std::uint8_t* bytes) noexcept {
  std::uint64_t word;
  std::memcpy(&word, bytes, sizeof word);
  if constexpr (std::endian::native == std::endian::big) {  // the first pixel is the lowest byte
    std::uint64_t swapped = 0;
    for (unsigned i = 0; i < 8; ++i) swapped |= ((word >> (8 * i)) & 0xff) << (56 - 8 * i);
    word = swapped;
  }
  return word;
}

/// The high bit of each byte: a > b, bytes unsigned. The lower seven bits are compared by a subtraction
/// that cannot borrow from the next byte, then the high bits decide where they differ.
std::uint64_t greater8(std::uint64_t a, std::uint64_t b) noexcept {
  const std::uint64_t low_b_at_least_a = (b | kHigh) - (a & ~kHigh);
  const std::uint64_t b_at_least_a = (b & ~a) | (~(a ^ b) & low_b_at_least_a);
  return ~b_at_least_a & kHigh;
}

/// The words of a group; nothing is read behind the row.
std::array<std::uint64_t, 8> words_of(const Group& group) noexcept {
  std::array<std::uint8_t, 64> end_of_row{};
  const std::uint8_t* p = group.pixels;
  if (group.missing != 0) {
    std::memcpy(end_of_row.data(), p, 64 - group.missing);
    p = end_of_row.data();
  }
  std::array<std::uint64_t, 8> words;
  for (std::size_t i = 0; i < 8; ++i) words[i] = load8(p + 8 * i);
  return words;
}

FoundRuns find_portable(const Rows& rows, std::uint32_t y, std::uint32_t y_end, PixelRun* runs) noexcept {
  const std::uint32_t width = rows.width, stride = position_stride(width);
  const auto list = [&](std::uint32_t row, Group* groups) {
    const std::uint8_t* pixels = rows.pixels + row * rows.pixels_stride;
    const std::uint8_t* coarse = rows.coarse + row * rows.coarse_stride;
    std::uint32_t count = 0;
    for (std::uint32_t x = 0; x < width; x += 64) {
      groups[count] = {pixels + x, row * stride + x, x + 64 > width ? x + 64 - width : 0};
      const std::uint64_t floor = std::uint64_t{coarse[x / kCoarsePixels]} * 0x0101010101010101u;
      std::uint64_t any = 0;
      for (const std::uint64_t word : words_of(groups[count])) any |= greater8(word, floor);
      count += any != 0 ? 1u : 0u;
    }
    return count;
  };
  const auto bits = [&](const Group& group) {
    const std::uint8_t* limit = rows.limit + group.position;
    std::uint64_t result = 0;
    unsigned shift = 0;
    for (const std::uint64_t word : words_of(group)) {
      // Gathers the eight high bits in the top byte.
      result |= (((greater8(word, load8(limit + shift)) >> 7) * 0x0102040810204080u) >> 56) << shift;
      shift += 8;
    }
    return result;
  };
  return find_runs(
      width, y, y_end, runs, [](std::uint32_t row) { return row; }, list, bits);
}

void measure_portable(const Rows& rows, const PixelRun* runs, std::uint32_t count,
                      BlobMoments* moments) noexcept {
  const std::uint32_t stride = position_stride(rows.width);
  for (std::uint32_t r = 0; r < count; ++r) {
    const std::uint32_t y = runs[r].begin / stride, x = runs[r].begin - y * stride;
    const std::uint32_t length = runs[r].end - runs[r].begin;
    const std::uint8_t* p = rows.pixels + y * rows.pixels_stride + x;
    const std::uint8_t* l = rows.limit + runs[r].begin;
    RunSums s{};
    for (std::uint32_t i = 0; i < length; ++i) {
      const std::uint32_t value = p[i], w = value - l[i];
      s.sum += value;
      s.w += w;
      s.wi += std::uint64_t{w} * i;
      s.wii += std::uint64_t{w} * i * i;
      s.peak = std::max(s.peak, value);
    }
    moments[r] = run_moments(x, y, length, s);
  }
}

}  // namespace

std::span<const RowKernels> row_kernels() noexcept {
  struct Table {
    std::array<RowKernels, 4> kernels{};
    std::size_t size = 0;
    Table() noexcept {
      for (const RowKernels& k : x86_row_kernels()) kernels[size++] = k;
      kernels[size++] = {"portable", find_portable, measure_portable};
    }
  };
  static const Table table;
  return {table.kernels.data(), table.size};
}

}  // namespace glint::gpu
