// SPDX-License-Identifier: MIT
// The Huffman tables that Motion JPEG leaves out (ITU-T T.81, annex K).
#pragma once

#include <array>

#include "host/capture/jpeg/jpeg_layout.hpp"

namespace glint {

struct StandardCodes {
  std::array<HuffmanCodes, JpegLayout::kTables> dc, ac;  ///< [0] brightness, [1] colour
};

/// As libjpeg-turbo has them. Throws Error.
StandardCodes standard_codes();

}  // namespace glint
