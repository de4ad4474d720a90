// SPDX-License-Identifier: MIT
// The row kernels for x86: AVX2 and SSE2, chosen by what the CPU says at run time.
#include "gpu/cpu/row_kernels.hpp"

#if defined(__x86_64__) && defined(__GNUC__)

#include <immintrin.h>

#include <algorithm>
#include <array>
#include <cstring>

#define GLINT_AVX2 __attribute__((target("avx2,bmi,popcnt")))

namespace glint::gpu {
namespace {

/// 16 bytes of ones, then of zeros: loading at 16 - n gives a mask of the first n bytes.
alignas(32) constexpr std::array<std::uint8_t, 32> kFirstBytes = {255, 255, 255, 255, 255, 255, 255, 255,
                                                                  255, 255, 255, 255, 255, 255, 255, 255};

/// A run is summed in pieces short enough that 32 bits hold sum of w i^2: 255 * 176^3 / 3 < 2^31, and
/// that i^2 fits the signed 16 bits of the multiplication: 175^2 < 2^15.
constexpr std::uint32_t kPiece = 176;

[[gnu::always_inline]] inline __m128i load16(const std::uint8_t* bytes) noexcept {
  return _mm_loadu_si128(reinterpret_cast<const __m128i*>(bytes));
}

[[gnu::always_inline]] inline void prefetch(const std::uint8_t* bytes) noexcept {
  _mm_prefetch(reinterpret_cast<const char*>(bytes), _MM_HINT_T0);
}

/// The pixels x .. x + n - 1 (n <= 16), zeros behind them; nothing is read behind the row.
[[gnu::always_inline]] inline __m128i load_pixels(const std::uint8_t* pixels, std::uint32_t x,
                                                  std::uint32_t n, std::uint32_t width) noexcept {
  if (x + 16 > width) [[unlikely]] {
    std::uint8_t end_of_row[16] = {};
    for (std::uint32_t i = 0; i < n; ++i) end_of_row[i] = pixels[x + i];
    return load16(end_of_row);
  }
  return _mm_and_si128(load16(pixels + x), load16(kFirstBytes.data() + 16 - n));
}

/// Adds a piece that starts at pixel `offset` of its run.
[[gnu::always_inline]] inline void add_piece(RunSums& s, std::uint64_t offset, std::uint32_t sum,
                                             std::uint32_t w, std::uint64_t wi, std::uint64_t wii,
                                             std::uint32_t peak) noexcept {
  s.sum += sum;
  s.w += w;
  s.wi += wi + offset * w;
  s.wii += wii + 2 * offset * wi + offset * offset * w;
  s.peak = std::max(s.peak, peak);
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

GLINT_AVX2 inline std::uint64_t above_bits(__m256i v, const std::uint8_t* limit) noexcept {
  const __m256i not_above = _mm256_cmpeq_epi8(_mm256_subs_epu8(v, load32(limit)), _mm256_setzero_si256());
  return ~static_cast<std::uint32_t>(_mm256_movemask_epi8(not_above));
}

GLINT_AVX2 std::uint32_t scan_avx2(const std::uint8_t* pixels, const std::uint8_t* limit,
                                   const std::uint8_t* limit_below, const std::uint8_t* coarse,
                                   std::uint32_t width, std::uint32_t* edges) noexcept {
  EdgeWriter writer(edges);
  std::uint32_t x = 0;
  for (; x + kCoarsePixels <= width; x += kCoarsePixels) {
    const std::uint8_t* p = pixels + x;
    const __m256i floor = _mm256_set1_epi8(static_cast<char>(coarse[x / kCoarsePixels]));
    const __m256i a = _mm256_max_epu8(load32(p), load32(p + 32));
    const __m256i b = _mm256_max_epu8(load32(p + 64), load32(p + 96));
    const __m256i c = _mm256_max_epu8(load32(p + 128), load32(p + 160));
    const __m256i d = _mm256_max_epu8(load32(p + 192), load32(p + 224));
    if (!any_above(_mm256_max_epu8(_mm256_max_epu8(a, b), _mm256_max_epu8(c, d)), floor)) continue;
    unsigned groups =
        static_cast<unsigned>(any_above(a, floor)) | static_cast<unsigned>(any_above(b, floor)) << 1 |
        static_cast<unsigned>(any_above(c, floor)) << 2 | static_cast<unsigned>(any_above(d, floor)) << 3;
    for (; groups != 0; groups &= groups - 1) {
      const auto group = static_cast<std::uint32_t>(std::countr_zero(groups)) * 64;
      const std::uint8_t* l = limit + x + group;
      prefetch(limit_below + x + group);
      writer.add(above_bits(load32(p + group), l) | (above_bits(load32(p + group + 32), l + 32) << 32),
                 x + group);
    }
  }
  std::array<std::uint8_t, 64> tail{};
  for (; x < width; x += 64) {
    const std::uint8_t* p = pixels + x;
    if (width - x < 64) {
      std::memcpy(tail.data(), p, width - x);
      p = tail.data();
    }
    const __m256i floor = _mm256_set1_epi8(static_cast<char>(coarse[x / kCoarsePixels]));
    const __m256i lower = load32(p), upper = load32(p + 32);
    if (!any_above(_mm256_max_epu8(lower, upper), floor)) continue;
    prefetch(limit_below + x);
    writer.add(above_bits(lower, limit + x) | (above_bits(upper, limit + x + 32) << 32), x);
  }
  return writer.finish();
}

GLINT_AVX2 void measure_avx2(const std::uint8_t* pixels, const std::uint8_t* limit, std::uint32_t width,
                             const std::uint32_t* edges, std::uint32_t runs, RunSums* sums) noexcept {
  const __m128i zero = _mm_setzero_si128();
  const __m256i first_index = _mm256_setr_epi16(0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15);
  for (std::uint32_t r = 0; r < runs; ++r) {
    const std::uint32_t length = edges[2 * r + 1] - edges[2 * r];
    RunSums s{};
    for (std::uint32_t offset = 0; offset < length; offset += kPiece) {
      const std::uint32_t end = std::min(offset + kPiece, length);
      __m128i sum_v = zero, sum_w = zero, peak = zero;
      __m256i wi = _mm256_setzero_si256(), wii = _mm256_setzero_si256(), index = first_index;
      for (std::uint32_t i = offset; i < end; i += 16) {
        const std::uint32_t x = edges[2 * r] + i;
        const __m128i v = load_pixels(pixels, x, std::min(16u, end - i), width);
        const __m128i w = _mm_subs_epu8(v, load16(limit + x));
        sum_v = _mm_add_epi64(sum_v, _mm_sad_epu8(v, zero));
        sum_w = _mm_add_epi64(sum_w, _mm_sad_epu8(w, zero));
        peak = _mm_max_epu8(peak, v);
        const __m256i w16 = _mm256_cvtepu8_epi16(w);
        wi = _mm256_add_epi32(wi, _mm256_madd_epi16(w16, index));
        wii = _mm256_add_epi32(wii, _mm256_madd_epi16(w16, _mm256_mullo_epi16(index, index)));
        index = _mm256_add_epi16(index, _mm256_set1_epi16(16));
      }
      const __m128i both = _mm_add_epi64(_mm_unpacklo_epi64(sum_v, sum_w), _mm_unpackhi_epi64(sum_v, sum_w));
      __m256i t = _mm256_hadd_epi32(wi, wii);  // per half: wi wi wii wii
      t = _mm256_hadd_epi32(t, t);             // per half: wi wii wi wii
      const __m128i moments = _mm_add_epi32(_mm256_castsi256_si128(t), _mm256_extracti128_si256(t, 1));
      // The smallest 16-bit word, the high byte of each having become 0: the complement of the peak.
      const __m128i inverse = _mm_xor_si128(peak, _mm_set1_epi8(-1));
      const __m128i smallest = _mm_minpos_epu16(_mm_min_epu8(inverse, _mm_srli_epi16(inverse, 8)));
      add_piece(s, offset, static_cast<std::uint32_t>(_mm_cvtsi128_si32(both)),
                static_cast<std::uint32_t>(_mm_extract_epi32(both, 2)),
                static_cast<std::uint32_t>(_mm_cvtsi128_si32(moments)),
                static_cast<std::uint32_t>(_mm_extract_epi32(moments, 1)),
                255u - (static_cast<std::uint32_t>(_mm_cvtsi128_si32(smallest)) & 255u));
    }
    sums[r] = s;
  }
}

// ---- SSE2, which every 64-bit x86 has ----

[[gnu::always_inline]] inline std::uint32_t above_bits16(__m128i v, __m128i limit) noexcept {
  const __m128i not_above = _mm_cmpeq_epi8(_mm_subs_epu8(v, limit), _mm_setzero_si128());
  return ~static_cast<std::uint32_t>(_mm_movemask_epi8(not_above)) & 0xffffu;
}

std::uint32_t scan_sse2(const std::uint8_t* pixels, const std::uint8_t* limit,
                        const std::uint8_t* limit_below, const std::uint8_t* coarse, std::uint32_t width,
                        std::uint32_t* edges) noexcept {
  EdgeWriter writer(edges);
  std::array<std::uint8_t, 64> tail{};
  for (std::uint32_t x = 0; x < width; x += 64) {
    const std::uint8_t* p = pixels + x;
    if (width - x < 64) {
      std::memcpy(tail.data(), p, width - x);
      p = tail.data();
    }
    const __m128i floor = _mm_set1_epi8(static_cast<char>(coarse[x / kCoarsePixels]));
    const __m128i v0 = load16(p), v1 = load16(p + 16), v2 = load16(p + 32), v3 = load16(p + 48);
    if (above_bits16(_mm_max_epu8(_mm_max_epu8(v0, v1), _mm_max_epu8(v2, v3)), floor) == 0) continue;
    const std::uint8_t* l = limit + x;
    prefetch(limit_below + x);
    const std::uint64_t bits = std::uint64_t{above_bits16(v0, load16(l))} |
                               (std::uint64_t{above_bits16(v1, load16(l + 16))} << 16) |
                               (std::uint64_t{above_bits16(v2, load16(l + 32))} << 32) |
                               (std::uint64_t{above_bits16(v3, load16(l + 48))} << 48);
    writer.add(bits, x);
  }
  return writer.finish();
}

[[gnu::always_inline]] inline std::uint32_t add_lanes(__m128i v) noexcept {
  v = _mm_add_epi32(v, _mm_srli_si128(v, 8));
  v = _mm_add_epi32(v, _mm_srli_si128(v, 4));
  return static_cast<std::uint32_t>(_mm_cvtsi128_si32(v));
}

void measure_sse2(const std::uint8_t* pixels, const std::uint8_t* limit, std::uint32_t width,
                  const std::uint32_t* edges, std::uint32_t runs, RunSums* sums) noexcept {
  const __m128i zero = _mm_setzero_si128(), sixteen = _mm_set1_epi16(16);
  for (std::uint32_t r = 0; r < runs; ++r) {
    const std::uint32_t length = edges[2 * r + 1] - edges[2 * r];
    RunSums s{};
    for (std::uint32_t offset = 0; offset < length; offset += kPiece) {
      const std::uint32_t end = std::min(offset + kPiece, length);
      __m128i sum_v = zero, sum_w = zero, peak = zero, wi = zero, wii = zero;
      __m128i index_lo = _mm_setr_epi16(0, 1, 2, 3, 4, 5, 6, 7);
      __m128i index_hi = _mm_setr_epi16(8, 9, 10, 11, 12, 13, 14, 15);
      for (std::uint32_t i = offset; i < end; i += 16) {
        const std::uint32_t x = edges[2 * r] + i;
        const __m128i v = load_pixels(pixels, x, std::min(16u, end - i), width);
        const __m128i w = _mm_subs_epu8(v, load16(limit + x));
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
      add_piece(s, offset, add_lanes(sum_v), add_lanes(sum_w), add_lanes(wi), add_lanes(wii),
                max_byte_sse2(peak));
    }
    sums[r] = s;
  }
}

}  // namespace

std::span<const RowKernels> x86_row_kernels() noexcept {
  static constexpr std::array<RowKernels, 2> kKernels = {
      {{"AVX2", scan_avx2, measure_avx2}, {"SSE2", scan_sse2, measure_sse2}}};
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
