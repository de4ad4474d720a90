// SPDX-License-Identifier: MIT
// The row kernels in plain C++, eight pixels in a 64-bit word; and the choice among all kernels.
#include "gpu/cpu/row_kernels.hpp"

#include <algorithm>
#include <array>
#include <cstring>
#include <vector>

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

std::uint32_t scan_portable(const std::uint8_t* pixels, const std::uint8_t* limit,
                            const std::uint8_t* /*limit_below*/, const std::uint8_t* coarse,
                            std::uint32_t width, std::uint32_t* edges) noexcept {
  EdgeWriter writer(edges);
  std::array<std::uint8_t, 64> tail{};
  for (std::uint32_t x = 0; x < width; x += 64) {
    const std::uint8_t* p = pixels + x;
    if (width - x < 64) {
      std::memcpy(tail.data(), p, width - x);
      p = tail.data();
    }
    const std::uint64_t floor = std::uint64_t{coarse[x / kCoarsePixels]} * 0x0101010101010101u;
    std::uint64_t any = 0;
    for (unsigned i = 0; i < 64; i += 8) any |= greater8(load8(p + i), floor);
    if (any == 0) continue;
    std::uint64_t bits = 0;
    for (unsigned i = 0; i < 64; i += 8) {
      const std::uint64_t above = greater8(load8(p + i), load8(limit + x + i));
      // Gathers the eight high bits in the top byte.
      bits |= (((above >> 7) * 0x0102040810204080u) >> 56) << i;
    }
    writer.add(bits, x);
  }
  return writer.finish();
}

void measure_portable(const std::uint8_t* pixels, const std::uint8_t* limit, std::uint32_t /*width*/,
                      const std::uint32_t* edges, std::uint32_t runs, RunSums* sums) noexcept {
  for (std::uint32_t r = 0; r < runs; ++r) {
    RunSums s{};
    const std::uint32_t length = edges[2 * r + 1] - edges[2 * r];
    const std::uint8_t* p = pixels + edges[2 * r];
    const std::uint8_t* l = limit + edges[2 * r];
    for (std::uint32_t i = 0; i < length; ++i) {
      const std::uint32_t value = p[i], w = value - l[i];
      s.sum += value;
      s.w += w;
      s.wi += std::uint64_t{w} * i;
      s.wii += std::uint64_t{w} * i * i;
      s.peak = std::max(s.peak, value);
    }
    sums[r] = s;
  }
}

}  // namespace

std::span<const RowKernels> row_kernels() noexcept {
  struct Table {
    std::array<RowKernels, 4> kernels{};
    std::size_t size = 0;
    Table() noexcept {
      for (const RowKernels& k : x86_row_kernels()) kernels[size++] = k;
      kernels[size++] = {"portable", scan_portable, measure_portable};
    }
  };
  static const Table table;
  return {table.kernels.data(), table.size};
}

}  // namespace glint::gpu
