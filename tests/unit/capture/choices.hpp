// SPDX-License-Identifier: MIT
// Where a test that tries everything takes its decisions from: random numbers, or a fuzzer's bytes.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

namespace glint::test {

class Choices {
 public:
  virtual ~Choices() = default;
  /// 0 to count - 1; the last of them is what a source without end may give for ever.
  virtual std::uint32_t below(std::uint32_t count) = 0;
  /// Any 32 bits.
  virtual std::uint32_t anything() = 0;

  bool one_in(std::uint32_t count) { return below(count) == 0; }
  template <typename Type, std::size_t kCount>
  const Type& one_of(const std::array<Type, kCount>& all) {
    return all[below(static_cast<std::uint32_t>(kCount))];
  }
};

}  // namespace glint::test
