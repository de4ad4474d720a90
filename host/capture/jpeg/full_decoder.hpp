// SPDX-License-Identifier: MIT
// Whole pictures out of JPEGs, through libjpeg-turbo.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>

#include "host/capture/grey_target.hpp"
#include "host/capture/jpeg/jpeg_result.hpp"

namespace glint {

/// libjpeg-turbo, brightness only, into the caller's memory. Thread-bound. Once a few pictures of one kind
/// were decoded nothing is allocated any more: the library's working memory comes from a block that is kept.
class FullJpegDecoder {
 public:
  /// Throws Error.
  FullJpegDecoder();
  ~FullJpegDecoder();
  FullJpegDecoder(const FullJpegDecoder&) = delete;
  FullJpegDecoder& operator=(const FullJpegDecoder&) = delete;

  /// One sequential JPEG, which may lack Huffman tables, as Motion JPEG does. Unless Good, the target holds
  /// nothing of use.
  [[nodiscard]] JpegResult decode(std::span<const std::byte> jpeg, const GreyTarget& target) noexcept;

  /// How often the library asked for working memory beyond the block, which grows then.
  std::uint64_t spills() const noexcept;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace glint
