// SPDX-License-Identifier: MIT
// The row kernels for x86: AVX2 and SSE2, chosen by what the CPU says at run time.
#include "gpu/cpu/row_kernels.hpp"

#if defined(__x86_64__) && defined(__GNUC__)

#include <immintrin.h>

#include <algorithm>
#include <array>
#include <cstring>

#include "gpu/cpu/run_writer.hpp"

#define GLINT_AVX2 __attribute__((target("avx2,bmi,popcnt")))

namespace glint::gpu {
namespace {

/// 32 bytes of ones, then of zeros: loading at 32 - n gives a mask of the first n bytes.
alignas(64) constexpr auto kFirstBytes = [] {
  std::array<std::uint8_t, 64> bytes{};
  for (std::size_t i = 0; i < 32; ++i) bytes[i] = 255;
  return bytes;
}();

/// A run is summed in pieces short enough that 32 bits hold sum of w i^2: 255 * 176^3 / 3 < 2^31, and
/// that i^2 fits the signed 16 bits of the multiplication: 175^2 < 2^15.
constexpr std::uint32_t kPiece = 176;

[[gnu::always_inline]] inline __m128i load16(const std::uint8_t* bytes) noexcept {
  return _mm_loadu_si128(reinterpret_cast<const __m128i*>(bytes));
}

/// The pixels x .. x + n - 1 (n <= 16), zeros behind them; nothing is read behind the row.
[[gnu::always_inline]] inline __m128i load_pixels(const std::uint8_t* pixels, std::uint32_t x,
                                                  std::uint32_t n, std::uint32_t width) noexcept {
  if (x + 16 > width) [[unlikely]] {
    std::uint8_t end_of_row[16] = {};
    for (std::uint32_t i = 0; i < n; ++i) end_of_row[i] = pixels[x + i];
    return load16(end_of_row);
  }
  return _mm_and_si128(load16(pixels + x), load16(kFirstBytes.data() + 32 - n));
}

[[gnu::always_inline]] inline std::uint32_t max_byte_sse2(__m128i v) noexcept {
  v = _mm_max_epu8(v, _mm_srli_si128(v, 8));
  v = _mm_max_epu8(v, _mm_srli_si128(v, 4));
  v = _mm_max_epu8(v, _mm_srli_si128(v, 2));
  v = _mm_max_epu8(v, _mm_srli_si128(v, 1));
  return static_cast<std::uint32_t>(_mm_cvtsi128_si32(v)) & 255u;
}

// ---- AVX2 ----

GLINT_AVX2 inline __m256i load32(const std::uint8_t* bytes) noexcept {
  return _mm256_loadu_si256(reinterpret_cast<const __m256i*>(bytes));
}

GLINT_AVX2 inline bool any_above(__m256i v, __m256i limit) noexcept {
  const __m256i excess = _mm256_subs_epu8(v, limit);
  return _mm256_testz_si256(excess, excess) == 0;
}

/// Which of 64 pixels are above their limits.
GLINT_AVX2 inline std::uint64_t above_bits(const std::uint8_t* p, const std::uint8_t* limit) noexcept {
  const auto not_above = [](const std::uint8_t* v, const std::uint8_t* l) GLINT_AVX2 {
    const __m256i excess = _mm256_subs_epu8(load32(v), load32(l));
    return static_cast<std::uint32_t>(
        _mm256_movemask_epi8(_mm256_cmpeq_epi8(excess, _mm256_setzero_si256())));
  };
  return ~(std::uint64_t{not_above(p, limit)} | (std::uint64_t{not_above(p + 32, limit + 32)} << 32));
}

GLINT_AVX2 inline __m256i max32(const std::uint8_t* a, const std::uint8_t* b) noexcept {
  return _mm256_max_epu8(load32(a), load32(b));
}

/// 64 bytes that may be read, of which the first `before` lie before the group.
struct Window {
  const std::uint8_t* pixels;
  std::uint32_t before;
};

/// The last 64 pixels of a row stand for a group that is not whole; if the row is too narrow for that, a copy
/// with zeros behind it.
[[gnu::always_inline]] inline Window window_of(const Group& group, std::uint32_t width,
                                               std::uint8_t (&narrow)[64]) noexcept {
  if (group.missing == 0 || width >= 64) [[likely]]
    return {group.pixels - group.missing, group.missing};
  std::memcpy(narrow, group.pixels, width);
  std::memset(narrow + width, 0, group.missing);
  return {narrow, 0};
}

/// How far the brightest of kCoarsePixels pixels are above the coarse limit.
GLINT_AVX2 inline __m256i excess_of_block(const std::uint8_t* p, std::uint8_t coarse) noexcept {
  const __m256i lower = _mm256_max_epu8(max32(p, p + 32), max32(p + 64, p + 96));
  const __m256i upper = _mm256_max_epu8(max32(p + 128, p + 160), max32(p + 192, p + 224));
  return _mm256_subs_epu8(_mm256_max_epu8(lower, upper), _mm256_set1_epi8(static_cast<char>(coarse)));
}

GLINT_AVX2 FoundRuns find_avx2(const Rows& rows, std::uint32_t y, std::uint32_t y_end,
                               PixelRun* runs) noexcept {
  constexpr std::uint32_t kBlocksAtOnce = 64 * 64 / kCoarsePixels;
  const std::uint32_t width = rows.width, blocks = width / kCoarsePixels, stride = position_stride(width);
  const auto skip = [&](std::uint32_t row) GLINT_AVX2 {
    if (blocks == 0) return row;
    const std::uint8_t* pixels = rows.pixels + row * rows.pixels_stride;
    const std::uint8_t* coarse = rows.coarse + row * rows.coarse_stride;
    for (; row < y_end; ++row, pixels += rows.pixels_stride, coarse += rows.coarse_stride) {
      __m256i excess = excess_of_block(pixels, coarse[0]);
      for (std::uint32_t b = 1; b < blocks; ++b)
        excess = _mm256_or_si256(excess, excess_of_block(pixels + b * kCoarsePixels, coarse[b]));
      if (blocks * kCoarsePixels != width) {  // the last pixels lie in two blocks
        const std::uint8_t least = std::min(coarse[blocks - 1], coarse[blocks]);
        excess = _mm256_or_si256(excess, excess_of_block(pixels + width - kCoarsePixels, least));
      }
      if (_mm256_testz_si256(excess, excess) == 0) break;
    }
    return row;
  };
  const auto list = [&](std::uint32_t row, Group* groups) GLINT_AVX2 {
    const std::uint8_t* pixels = rows.pixels + row * rows.pixels_stride;
    const std::uint8_t* coarse = rows.coarse + row * rows.coarse_stride;
    std::uint32_t count = 0;
    for (std::uint32_t first = 0; first < blocks; first += kBlocksAtOnce) {
      std::uint64_t lit = 0;
      const std::uint32_t end = std::min(first + kBlocksAtOnce, blocks);
      for (std::uint32_t b = first; b < end; ++b) {
        const std::uint8_t* p = pixels + b * kCoarsePixels;
        const __m256i floor = _mm256_set1_epi8(static_cast<char>(coarse[b]));
        const unsigned four = static_cast<unsigned>(any_above(max32(p, p + 32), floor)) |
                              static_cast<unsigned>(any_above(max32(p + 64, p + 96), floor)) << 1 |
                              static_cast<unsigned>(any_above(max32(p + 128, p + 160), floor)) << 2 |
                              static_cast<unsigned>(any_above(max32(p + 192, p + 224), floor)) << 3;
        lit |= std::uint64_t{four} << (4 * (b - first));
      }
      if (lit == 0) continue;
      const std::uint32_t x = first * kCoarsePixels;
      count += list_groups(lit, pixels + x, rows.limit, row * stride + x, groups + count);
    }
    for (std::uint32_t x = blocks * kCoarsePixels; x < width; x += 64) {
      alignas(32) std::uint8_t narrow[64];
      groups[count] = {pixels + x, row * stride + x, x + 64 > width ? x + 64 - width : 0};
      const std::uint8_t* p = window_of(groups[count], width, narrow).pixels;
      const __m256i floor = _mm256_set1_epi8(static_cast<char>(coarse[x / kCoarsePixels]));
      count += static_cast<std::uint32_t>(any_above(max32(p, p + 32), floor));
    }
    return count;
  };
  const auto bits = [&](const Group& group) GLINT_AVX2 {
    alignas(32) std::uint8_t narrow[64];
    const auto [p, before] = window_of(group, width, narrow);
    return above_bits(p, rows.limit + group.position - before) >> before;
  };
  return find_runs(width, y, y_end, runs, skip, list, bits);
}

/// The first n <= 32 bytes.
GLINT_AVX2 inline __m256i first_bytes(std::uint32_t n) noexcept {
  return load32(kFirstBytes.data() + 32 - n);
}

/// A piece of a run, at most 32 pixels: `pixels` has zeros behind them. i^2 = 16 q + r with q and r small
/// enough for the multiplication of bytes.
GLINT_AVX2 [[gnu::always_inline]] inline RunSums sum_piece(__m256i pixels,
                                                           const std::uint8_t* limit) noexcept {
  struct Table {
    std::uint8_t index[32], square16[32], square1[32];
  };
  alignas(32) static constexpr Table kTable = [] {
    Table table{};
    for (unsigned i = 0; i < 32; ++i) {
      table.index[i] = static_cast<std::uint8_t>(i);
      table.square16[i] = static_cast<std::uint8_t>(i * i / 16);
      table.square1[i] = static_cast<std::uint8_t>(i * i % 16);
    }
    return table;
  }();
  const __m256i zero = _mm256_setzero_si256(), one = _mm256_set1_epi16(1), sixteen = _mm256_set1_epi16(16);
  const __m256i w = _mm256_subs_epu8(pixels, load32(limit));
  // In each 64 bits the sum of the pixels, and 2^32 times the sum of w.
  const __m256i sums =
      _mm256_or_si256(_mm256_sad_epu8(pixels, zero), _mm256_slli_epi64(_mm256_sad_epu8(w, zero), 32));
  const __m128i sums2 = _mm_add_epi32(_mm256_castsi256_si128(sums), _mm256_extracti128_si256(sums, 1));
  const auto sum_w =
      static_cast<std::uint64_t>(_mm_cvtsi128_si64(_mm_add_epi32(sums2, _mm_unpackhi_epi64(sums2, sums2))));
  const __m256i wi = _mm256_madd_epi16(_mm256_maddubs_epi16(w, load32(kTable.index)), one);
  const __m256i wii =
      _mm256_add_epi32(_mm256_madd_epi16(_mm256_maddubs_epi16(w, load32(kTable.square16)), sixteen),
                       _mm256_madd_epi16(_mm256_maddubs_epi16(w, load32(kTable.square1)), one));
  __m256i t = _mm256_hadd_epi32(wi, wii);  // per half: wi wi wii wii
  t = _mm256_hadd_epi32(t, t);             // per half: wi wii wi wii
  const auto wi_wii = static_cast<std::uint64_t>(
      _mm_cvtsi128_si64(_mm_add_epi32(_mm256_castsi256_si128(t), _mm256_extracti128_si256(t, 1))));
  // The smallest 16-bit word, the high byte of each having become 0: the complement of the peak.
  const __m128i brightest = _mm_max_epu8(_mm256_castsi256_si128(pixels), _mm256_extracti128_si256(pixels, 1));
  const __m128i inverse = _mm_xor_si128(brightest, _mm_set1_epi8(-1));
  const __m128i smallest = _mm_minpos_epu16(_mm_min_epu8(inverse, _mm_srli_epi16(inverse, 8)));
  return {wi_wii & 0xffffffffu, wi_wii >> 32, static_cast<std::uint32_t>(sum_w),
          static_cast<std::uint32_t>(sum_w >> 32), static_cast<std::uint8_t>(~_mm_cvtsi128_si32(smallest))};
}

/// Runs of more than 32 pixels, and those so close to the end of their row that not all of 32 pixels may be
/// read.
GLINT_AVX2 [[gnu::noinline]] RunSums sum_pieces_avx2(const std::uint8_t* pixels, const std::uint8_t* limit,
                                                     std::uint32_t length, std::uint32_t readable) noexcept {
  RunSums s{};
  for (std::uint32_t offset = 0; offset < length; offset += 32) {
    const std::uint32_t n = std::min(32u, length - offset);
    alignas(32) std::uint8_t end_of_row[32] = {};
    const std::uint8_t* piece = pixels + offset;
    if (offset + 32 > readable) {
      for (std::uint32_t i = 0; i < n; ++i) end_of_row[i] = piece[i];
      piece = end_of_row;
    }
    add_piece(s, offset, sum_piece(_mm256_and_si256(load32(piece), first_bytes(n)), limit + offset));
  }
  return s;
}

GLINT_AVX2 void measure_avx2(const Rows& rows, const PixelRun* runs, std::uint32_t count,
                             BlobMoments* moments) noexcept {
  const RowOfPosition row_of(rows.width);
  const std::uint32_t stride = position_stride(rows.width);
  for (std::uint32_t r = 0; r < count; ++r) {
    const std::uint32_t begin = runs[r].begin, length = runs[r].end - begin;
    const std::uint32_t y = row_of(begin), x = begin - y * stride;
    const std::uint8_t* pixels = rows.pixels + y * rows.pixels_stride + x;
    const std::uint8_t* limit = rows.limit + begin;
    RunSums s;
    if (length <= 32 && x + 32 <= rows.width) [[likely]] {
      s = sum_piece(_mm256_and_si256(load32(pixels), first_bytes(length)), limit);
    } else {
      s = sum_pieces_avx2(pixels, limit, length, rows.width - x);
    }
    moments[r] = run_moments(x, y, length, s);
  }
}

// ---- SSE2, which every 64-bit x86 has ----

[[gnu::always_inline]] inline std::uint32_t above_bits16(__m128i v, __m128i limit) noexcept {
  const __m128i not_above = _mm_cmpeq_epi8(_mm_subs_epu8(v, limit), _mm_setzero_si128());
  return ~static_cast<std::uint32_t>(_mm_movemask_epi8(not_above)) & 0xffffu;
}

/// How far the brightest of kCoarsePixels pixels are above the coarse limit.
__m128i excess_of_block16(const std::uint8_t* p, std::uint8_t coarse) noexcept {
  __m128i brightest = load16(p);
  for (std::uint32_t i = 16; i < kCoarsePixels; i += 16) brightest = _mm_max_epu8(brightest, load16(p + i));
  return _mm_subs_epu8(brightest, _mm_set1_epi8(static_cast<char>(coarse)));
}

FoundRuns find_sse2(const Rows& rows, std::uint32_t y, std::uint32_t y_end, PixelRun* runs) noexcept {
  const std::uint32_t width = rows.width, stride = position_stride(width);
  const auto skip = [&](std::uint32_t row) {
    const std::uint32_t blocks = width / kCoarsePixels;
    if (blocks == 0) return row;
    for (; row < y_end; ++row) {
      const std::uint8_t* pixels = rows.pixels + row * rows.pixels_stride;
      const std::uint8_t* coarse = rows.coarse + row * rows.coarse_stride;
      __m128i excess = excess_of_block16(pixels, coarse[0]);
      for (std::uint32_t b = 1; b < blocks; ++b)
        excess = _mm_or_si128(excess, excess_of_block16(pixels + b * kCoarsePixels, coarse[b]));
      if (blocks * kCoarsePixels != width) {  // the last pixels lie in two blocks
        const std::uint8_t least = std::min(coarse[blocks - 1], coarse[blocks]);
        excess = _mm_or_si128(excess, excess_of_block16(pixels + width - kCoarsePixels, least));
      }
      if (above_bits16(excess, _mm_setzero_si128()) != 0) break;
    }
    return row;
  };
  const auto list = [&](std::uint32_t row, Group* groups) {
    const std::uint8_t* pixels = rows.pixels + row * rows.pixels_stride;
    const std::uint8_t* coarse = rows.coarse + row * rows.coarse_stride;
    std::uint32_t count = 0;
    const auto list_if_bright = [&](const std::uint8_t* p, std::uint32_t x, std::uint32_t missing) {
      const __m128i brightest =
          _mm_max_epu8(_mm_max_epu8(load16(p), load16(p + 16)), _mm_max_epu8(load16(p + 32), load16(p + 48)));
      if (above_bits16(brightest, _mm_set1_epi8(static_cast<char>(coarse[x / kCoarsePixels]))) == 0) return;
      groups[count] = {pixels + x, row * stride + x, missing};
      __builtin_prefetch(rows.limit + groups[count].position);
      ++count;
    };
    const std::uint32_t whole = width / 64 * 64;
    for (std::uint32_t x = 0; x < whole; x += 64) list_if_bright(pixels + x, x, 0);
    if (whole != width) {
      alignas(16) std::uint8_t narrow[64];
      const std::uint32_t missing = whole + 64 - width;
      list_if_bright(window_of({pixels + whole, 0, missing}, width, narrow).pixels, whole, missing);
    }
    return count;
  };
  const auto bits = [&](const Group& group) {
    alignas(16) std::uint8_t narrow[64];
    const auto [p, before] = window_of(group, width, narrow);
    const std::uint8_t* l = rows.limit + group.position - before;
    return (std::uint64_t{above_bits16(load16(p), load16(l))} |
            (std::uint64_t{above_bits16(load16(p + 16), load16(l + 16))} << 16) |
            (std::uint64_t{above_bits16(load16(p + 32), load16(l + 32))} << 32) |
            (std::uint64_t{above_bits16(load16(p + 48), load16(l + 48))} << 48)) >>
           before;
  };
  return find_runs(width, y, y_end, runs, skip, list, bits);
}

[[gnu::always_inline]] inline std::uint32_t add_lanes(__m128i v) noexcept {
  v = _mm_add_epi32(v, _mm_srli_si128(v, 8));
  v = _mm_add_epi32(v, _mm_srli_si128(v, 4));
  return static_cast<std::uint32_t>(_mm_cvtsi128_si32(v));
}

void measure_sse2(const Rows& rows, const PixelRun* runs, std::uint32_t count,
                  BlobMoments* moments) noexcept {
  const __m128i zero = _mm_setzero_si128(), sixteen = _mm_set1_epi16(16);
  const RowOfPosition row_of(rows.width);
  for (std::uint32_t r = 0; r < count; ++r) {
    const std::uint32_t begin = runs[r].begin, length = runs[r].end - begin;
    const std::uint32_t y = row_of(begin), x = begin - y * position_stride(rows.width);
    const std::uint8_t* pixels = rows.pixels + y * rows.pixels_stride;
    const std::uint8_t* limit = rows.limit + begin;
    RunSums s{};
    for (std::uint32_t offset = 0; offset < length; offset += kPiece) {
      const std::uint32_t end = std::min(offset + kPiece, length);
      __m128i sum_v = zero, sum_w = zero, peak = zero, wi = zero, wii = zero;
      __m128i index_lo = _mm_setr_epi16(0, 1, 2, 3, 4, 5, 6, 7);
      __m128i index_hi = _mm_setr_epi16(8, 9, 10, 11, 12, 13, 14, 15);
      for (std::uint32_t i = offset; i < end; i += 16) {
        const __m128i v = load_pixels(pixels, x + i, std::min(16u, end - i), rows.width);
        const __m128i w = _mm_subs_epu8(v, load16(limit + i));
        sum_v = _mm_add_epi64(sum_v, _mm_sad_epu8(v, zero));
        sum_w = _mm_add_epi64(sum_w, _mm_sad_epu8(w, zero));
        peak = _mm_max_epu8(peak, v);
        const __m128i lo = _mm_unpacklo_epi8(w, zero), hi = _mm_unpackhi_epi8(w, zero);
        wi = _mm_add_epi32(wi, _mm_add_epi32(_mm_madd_epi16(lo, index_lo), _mm_madd_epi16(hi, index_hi)));
        wii = _mm_add_epi32(wii, _mm_add_epi32(_mm_madd_epi16(lo, _mm_mullo_epi16(index_lo, index_lo)),
                                               _mm_madd_epi16(hi, _mm_mullo_epi16(index_hi, index_hi))));
        index_lo = _mm_add_epi16(index_lo, sixteen);
        index_hi = _mm_add_epi16(index_hi, sixteen);
      }
      add_piece(s, offset,
                {add_lanes(wi), add_lanes(wii), add_lanes(sum_v), add_lanes(sum_w), max_byte_sse2(peak)});
    }
    moments[r] = run_moments(x, y, length, s);
  }
}

}  // namespace

std::span<const RowKernels> x86_row_kernels() noexcept {
  static constexpr std::array<RowKernels, 2> kKernels = {
      {{"AVX2", find_avx2, measure_avx2}, {"SSE2", find_sse2, measure_sse2}}};
  const bool avx2 =
      __builtin_cpu_supports("avx2") && __builtin_cpu_supports("bmi") && __builtin_cpu_supports("popcnt");
  return std::span<const RowKernels>(kKernels).subspan(avx2 ? 0 : 1);
}

}  // namespace glint::gpu

#else

namespace glint::gpu {
std::span<const RowKernels> x86_row_kernels() noexcept { return {}; }
}  // namespace glint::gpu

#endif
