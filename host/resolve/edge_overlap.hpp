// SPDX-License-Identifier: MIT
// How much of a pixel two blurred edges cover together.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <vector>

namespace glint {

/// A pixel sees one region to a share of p and another to q. What it sees of both at once depends on how
/// their edges lie: with edges that are straight over the width of the blur it is the bivariate normal
/// distribution at the quantiles of p and q, with the cosine of the angle between the edges' normals as
/// correlation. So discs that touch from outside (-1) share nothing, and one before the other shares all.
class EdgeOverlap {
 public:
  EdgeOverlap();

  struct Value {
    float share, by_p, by_q;
  };
  /// p and q in [0, 1]; cosine in [-1, 1].
  Value at(float p, float q, float cosine) const noexcept {
    constexpr auto kLast = static_cast<float>(kShares - 1);
    const float x = std::clamp(p, 0.0f, 1.0f) * kLast, y = std::clamp(q, 0.0f, 1.0f) * kLast;
    const float z = angle(cosine) * (static_cast<float>(kAngles - 1) / kPi);
    const std::size_t i = cell(x, kShares), j = cell(y, kShares), k = cell(z, kAngles);
    const float fx = x - static_cast<float>(i), fy = y - static_cast<float>(j),
                fz = z - static_cast<float>(k);
    const float* at = shares_.data() + (k * kShares + i) * kShares + j;
    const auto between = [fz, at](std::size_t o) { return at[o] + fz * (at[o + kLayer] - at[o]); };
    const float v00 = between(0), v01 = between(1), v10 = between(kShares), v11 = between(kShares + 1);
    const float low = v00 + fy * (v01 - v00), high = v10 + fy * (v11 - v10);
    return {low + fx * (high - low), (high - low) * kLast,
            (v01 - v00 + fx * (v11 - v10 - v01 + v00)) * kLast};
  }

 private:
  static constexpr std::size_t kShares = 33, kAngles = 17, kLayer = kShares * kShares;
  static constexpr float kPi = 3.14159265f;
  static std::size_t cell(float at, std::size_t nodes) noexcept {
    return std::min(static_cast<std::size_t>(static_cast<int>(at)), nodes - 2);
  }
  /// Arc cosine to 7e-5 (Abramowitz and Stegun, 4.4.45), in [0, pi].
  static float angle(float cosine) noexcept {
    const float a = std::min(std::abs(cosine), 1.0f);
    const float arc =
        std::sqrt(1.0f - a) * (1.5707288f + a * (-0.2121144f + a * (0.0742610f - a * 0.0187293f)));
    return std::clamp(cosine < 0.0f ? kPi - arc : arc, 0.0f, kPi);
  }
  std::vector<float> shares_;  // [angle][p][q]
};

}  // namespace glint
