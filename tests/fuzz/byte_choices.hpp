// SPDX-License-Identifier: MIT
// Decisions out of a fuzzer's bytes.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <span>

#include "tests/unit/capture/choices.hpp"

namespace glint::test {

/// Reads from the front. Behind the end every decision is the last one: nothing is spoilt any more.
class ByteChoices final : public Choices {
 public:
  explicit ByteChoices(std::span<const std::uint8_t> bytes) : bytes_(bytes) {}

  std::uint32_t below(std::uint32_t count) override {
    if (bytes_.empty()) return count - 1;
    return (count <= 256 ? byte() : anything()) % count;
  }
  std::uint32_t anything() override {
    std::uint32_t value = 0;
    for (unsigned n = 0; n < 4; ++n) value |= std::uint32_t{byte()} << (8 * n);
    return value;
  }
  /// At most `count` bytes as they are.
  std::span<const std::uint8_t> take(std::size_t count) {
    const std::span<const std::uint8_t> taken = bytes_.first(std::min(count, bytes_.size()));
    bytes_ = bytes_.subspan(taken.size());
    return taken;
  }
  std::span<const std::uint8_t> rest() { return take(bytes_.size()); }
  bool empty() const noexcept { return bytes_.empty(); }

 private:
  std::uint8_t byte() {
    if (bytes_.empty()) return 0;
    const std::uint8_t first = bytes_.front();
    bytes_ = bytes_.subspan(1);
    return first;
  }
  std::span<const std::uint8_t> bytes_;
};

}  // namespace glint::test
