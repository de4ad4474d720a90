// SPDX-License-Identifier: MIT
// Motion JPEG to grey pixels.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "host/capture/jpeg/bright_decoder.hpp"
#include "host/capture/jpeg/full_decoder.hpp"

namespace glint {

/// Brightness only, into the caller's memory. Thread-bound. Once a few pictures of one kind were decoded
/// nothing is allocated any more.
class JpegDecoder {
 public:
  /// From now on pixels of pictures of this size matter only where they are above `limit`; see
  /// BrightJpegDecoder. Throws std::bad_alloc.
  void set_limit(std::span<const std::uint8_t> limit, FrameSize size) { bright_.set_limit(limit, size); }

  /// One sequential JPEG, which may lack Huffman tables, as Motion JPEG does. Unless Good, the target holds
  /// nothing of use. libjpeg-turbo has the last word on any picture that is not plainly without fault.
  [[nodiscard]] JpegResult decode(std::span<const std::byte> jpeg, const GreyTarget& target) noexcept {
    if (bright_.has_limit(target.size) && bright_.decode(jpeg, target)) return JpegResult::Good;
    return full_.decode(jpeg, target);
  }

 private:
  BrightJpegDecoder bright_;
  FullJpegDecoder full_;
};

}  // namespace glint
