// SPDX-License-Identifier: MIT
// Motion JPEG to grey pixels.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>

#include "host/capture/grey_target.hpp"

namespace glint {

enum class JpegResult : std::uint8_t {
  Good,
  Truncated,  ///< ends before its end marker
  Corrupt,    ///< anything else that the decoder so much as warns of
  WrongSize,  ///< of another size than the target
};

/// libjpeg-turbo, brightness only, into the caller's memory. Thread-bound. Once a few pictures of one kind
/// were decoded nothing is allocated any more: the library's working memory comes from a block that is kept.
class JpegDecoder {
 public:
  /// Throws Error.
  JpegDecoder();
  ~JpegDecoder();
  JpegDecoder(const JpegDecoder&) = delete;
  JpegDecoder& operator=(const JpegDecoder&) = delete;

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
