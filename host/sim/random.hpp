// SPDX-License-Identifier: MIT
// Random numbers that are the same on every machine (the standard library's distributions are not).
#pragma once

#include <array>
#include <bit>
#include <cstdint>

namespace glint::sim {

/// Mixes 64 bits thoroughly: the finalizer of SplitMix64 (Steele, Lea and Flood, OOPSLA 2014).
constexpr std::uint64_t mix(std::uint64_t z) noexcept {
  z += 0x9e3779b97f4a7c15u;
  z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9u;
  z = (z ^ (z >> 27)) * 0x94d049bb133111ebu;
  return z ^ (z >> 31);
}

/// What a stream of random numbers is for, so that no two uses share one.
enum class Stream : std::uint64_t {
  Rig = 1,
  Motion,
  Spots,
  Poles,
  Pattern,
  DarkNoise,
  FrameNoise,
  Drop,
  Duplicate,
  Late,
  BoardPose,
  BoardNoise,
  Bodies,
  Crossings,
  Person,
  Missing,
  Blinks,
  CalibrationError
};

/// Seed of one stream, from the run's seed and up to two indices (camera, tick).
constexpr std::uint64_t stream_seed(std::uint64_t seed, Stream stream, std::uint64_t a = 0,
                                    std::uint64_t b = 0) noexcept {
  return mix(mix(mix(mix(seed) ^ static_cast<std::uint64_t>(stream)) ^ a) ^ b);
}

/// xoshiro256++ 1.0 (Blackman and Vigna, ACM TOMS 47(4), 2021).
class Random {
 public:
  explicit Random(std::uint64_t seed) noexcept {
    for (std::uint64_t& word : state_) word = mix(seed++);
  }
  std::uint64_t bits() noexcept {
    const std::uint64_t result = std::rotl(state_[0] + state_[3], 23) + state_[0];
    const std::uint64_t shifted = state_[1] << 17;
    state_[2] ^= state_[0];
    state_[3] ^= state_[1];
    state_[1] ^= state_[2];
    state_[0] ^= state_[3];
    state_[2] ^= shifted;
    state_[3] = std::rotl(state_[3], 45);
    return result;
  }
  /// In [0, 1), 53 bits.
  double uniform() noexcept { return static_cast<double>(bits() >> 11) * 0x1p-53; }
  double uniform(double low, double high) noexcept { return low + (high - low) * uniform(); }

 private:
  std::array<std::uint64_t, 4> state_{};
};

/// Standard normal numbers from a table of 4096 quantiles: mean 0 and variance 1 to 1e-4, tails cut at 3.7
/// sd. Entries are multiples of 2^-12, so that last-bit differences between maths libraries vanish.
class NormalTable {
 public:
  NormalTable();
  float operator[](std::uint64_t bits12) const noexcept { return values_[bits12 & 4095u]; }
  float draw(Random& random) const noexcept { return values_[random.bits() >> 52]; }

 private:
  std::array<float, 4096> values_{};
};

}  // namespace glint::sim
