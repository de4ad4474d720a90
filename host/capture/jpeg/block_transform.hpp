// SPDX-License-Identifier: MIT
// One block of 8x8 coefficients to pixels.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

namespace glint {

/// Dequantised coefficients in rows of rising vertical frequency. The first is the mean times 8.
struct JpegBlock {
  alignas(16) std::array<std::int32_t, 64> coefficients{};
};

/// The inverse cosine transform (ITU-T T.81, A.3.3) plus 128, limited to 0..255: 8 rows of stride_bytes.
/// Rounds as libjpeg-turbo's accurate integer transform does, so that both give the same pixels. False: so
/// far out of range (by 384) that no picture can have been meant.
[[nodiscard]] bool transform_block(const JpegBlock& block, std::uint8_t* pixels,
                                   std::size_t stride_bytes) noexcept;

/// Where in such a block the coefficient belongs that comes n-th in the file.
extern const std::array<std::uint8_t, 64> kPlaceInBlock;

}  // namespace glint
