// SPDX-License-Identifier: MIT
// What can become of a JPEG.
#pragma once

#include <cstdint>

namespace glint {

enum class JpegResult : std::uint8_t {
  Good,
  Truncated,  ///< ends before its end marker
  Corrupt,    ///< anything else that the decoder so much as warns of
  WrongSize,  ///< of another size than the target
};

}  // namespace glint
