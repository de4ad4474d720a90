// SPDX-License-Identifier: MIT
// The transform along columns, then along rows, even and odd frequencies apart.
#include "host/capture/jpeg/block_transform.hpp"

#include <algorithm>
#include <cstring>
#include <utility>
#ifdef __SSE2__
#include <emmintrin.h>
#endif

namespace glint {
namespace {

using Lanes = std::int32_t __attribute__((vector_size(16)));  // one number of each of four columns or rows
using Strip = std::array<Lanes, 8>;

// sqrt(2) cos(n pi / 16) in units of 2^-13. Where the same cosine stands with numbers that differ by one,
// those are sums of rounded constants in the method by Loeffler, Ligtenberg and Moschytz (ICASSP 1989, with
// 11 multiplications), which libjpeg-turbo uses: what counts here is to round alike.
constexpr unsigned kOne = 13;
constexpr std::int16_t kC1 = 11363, kC2a = 10703, kC2b = 10704, kC3 = 9633, kC5a = 6437, kC5b = 6436,
                       kC6 = 4433, kC7a = 2260, kC7b = 2261, kC7c = 2259, kC1b = 11362;
constexpr unsigned kFraction = 2;       // bits kept between the two passes
constexpr std::int32_t kWildest = 512;  // less 128; from here on the sums of libjpeg-turbo turn over

#ifdef __SSE2__
/// Two numbers of 16 bits in each lane.
using Two = Lanes;
Two two(Lanes a, Lanes b) noexcept { return (a & 0xffff) | (b << 16); }
Lanes weighted(Two both, std::int16_t of_a, std::int16_t of_b) noexcept {
  const auto weights = static_cast<std::int32_t>(std::uint32_t{static_cast<std::uint16_t>(of_b)} << 16 |
                                                 static_cast<std::uint16_t>(of_a));
  return Lanes(_mm_madd_epi16(__m128i(both), _mm_set1_epi32(weights)));
}
#else
using Two = std::pair<Lanes, Lanes>;
Two two(Lanes a, Lanes b) noexcept { return {a, b}; }
Lanes weighted(const Two& both, std::int16_t of_a, std::int16_t of_b) noexcept {
  return both.first * of_a + both.second * of_b;
}
#endif

/// Leaves the results without their last `shift` bits, rounded.
void transform(Strip& v, unsigned shift) noexcept {
  const std::int32_t half = 1 << (shift - 1);
  const Lanes sum = ((v[0] + v[4]) << kOne) + half, difference = ((v[0] - v[4]) << kOne) + half;
  const Two v26 = two(v[2], v[6]), v13 = two(v[1], v[3]), v57 = two(v[5], v[7]);
  const Lanes outer = weighted(v26, kC2a, kC6), inner = weighted(v26, kC6, -kC2b);
  const std::array<Lanes, 4> even{sum + outer, difference + inner, difference - inner, sum - outer};
  const std::array<Lanes, 4> odd{weighted(v13, kC1, kC3) + weighted(v57, kC5a, kC7a),
                                 weighted(v13, kC3, -kC7c) + weighted(v57, -kC1b, -kC5b),
                                 weighted(v13, kC5a, -kC1b) + weighted(v57, kC7b, kC3),
                                 weighted(v13, kC7a, -kC5b) + weighted(v57, kC3, -kC1)};
  for (std::size_t n = 0; n < 4; ++n) {
    v[n] = (even[n] + odd[n]) >> static_cast<int>(shift);
    v[7 - n] = (even[n] - odd[n]) >> static_cast<int>(shift);
  }
}

/// Four rows of four.
void transpose(Lanes& a, Lanes& b, Lanes& c, Lanes& d) noexcept {
  const Lanes ab_low = __builtin_shufflevector(a, b, 0, 4, 1, 5),
              ab_high = __builtin_shufflevector(a, b, 2, 6, 3, 7);
  const Lanes cd_low = __builtin_shufflevector(c, d, 0, 4, 1, 5),
              cd_high = __builtin_shufflevector(c, d, 2, 6, 3, 7);
  a = __builtin_shufflevector(ab_low, cd_low, 0, 1, 4, 5);
  b = __builtin_shufflevector(ab_low, cd_low, 2, 3, 6, 7);
  c = __builtin_shufflevector(ab_high, cd_high, 0, 1, 4, 5);
  d = __builtin_shufflevector(ab_high, cd_high, 2, 3, 6, 7);
}

/// The left and the right half of an 8x8 block.
void transpose(Strip& left, Strip& right) noexcept {
  for (Strip* const half : {&left, &right}) {
    Strip& v = *half;
    transpose(v[0], v[1], v[2], v[3]);
    transpose(v[4], v[5], v[6], v[7]);
  }
  for (std::size_t n = 0; n < 4; ++n) std::swap(left[n + 4], right[n]);
}

/// Eight grey levels less 128, limited.
void put_row(Lanes left, Lanes right, std::uint8_t* pixels) noexcept {
#ifdef __SSE2__
  const __m128i words = _mm_packs_epi32(__m128i(left + 128), __m128i(right + 128));
  _mm_storel_epi64(reinterpret_cast<__m128i*>(pixels), _mm_packus_epi16(words, words));
#else
  for (std::size_t n = 0; n < 8; ++n)
    pixels[n] = static_cast<std::uint8_t>(std::clamp((n < 4 ? left[n] : right[n - 4]) + 128, 0, 255));
#endif
}

constexpr std::array<std::uint8_t, 64> zig_zag() noexcept {
  std::array<std::uint8_t, 64> places{};
  int x = 0, y = 0;
  for (std::uint8_t& place : places) {
    place = static_cast<std::uint8_t>(y * 8 + x);
    const bool up = (x + y) % 2 == 0;
    if (up ? x == 7 : y == 7) {  // along the far border
      (up ? y : x) += 1;
    } else if (up ? y == 0 : x == 0) {  // along the near one
      (up ? x : y) += 1;
    } else {
      x += up ? 1 : -1;
      y += up ? -1 : 1;
    }
  }
  return places;
}

}  // namespace

const std::array<std::uint8_t, 64> kPlaceInBlock = zig_zag();

bool transform_block(const JpegBlock& block, std::uint8_t* pixels, std::size_t stride_bytes) noexcept {
  Strip left, right;
  for (std::size_t n = 0; n < 8; ++n) {
    std::memcpy(&left[n], &block.coefficients[n * 8], sizeof left[n]);
    std::memcpy(&right[n], &block.coefficients[n * 8 + 4], sizeof right[n]);
  }
  // Both passes multiply by sqrt(8).
  for (const unsigned shift : {kOne - kFraction, kOne + kFraction + 3}) {
    transform(left, shift);
    transform(right, shift);
    transpose(left, right);
  }
  Lanes wild{};
  for (std::size_t y = 0; y < 8; ++y) {
    put_row(left[y], right[y], pixels + y * stride_bytes);
    wild |= (left[y] >= kWildest) | (left[y] < -kWildest) | (right[y] >= kWildest) | (right[y] < -kWildest);
  }
  return (wild[0] | wild[1] | wild[2] | wild[3]) == 0;
}

}  // namespace glint
