// SPDX-License-Identifier: MIT
// Blobs drawn into the picture they were found in, for tuning by eye.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "shaders/interface/blob_record.h"

namespace glint {

/// Borrowed 8-bit grey pixels, row by row.
struct GreyPixels {
  const std::uint8_t* pixels = nullptr;
  std::uint32_t width_px = 0, height_px = 0, stride_bytes = 0;
};

enum class OverlayLabel : std::uint8_t { None, Area, Number };

struct OverlayOptions {
  OverlayLabel label = OverlayLabel::Area;  ///< beside each box: area_px, or the blob's number from 1
  std::uint32_t margin_px = 2;  ///< between the bounding box and the drawn box, to leave the blob visible
};

/// Replaces `rgb` by width_px * height_px * 3 bytes: the grey image with a box and a centroid cross for
/// each blob. Green: a good blob; amber: saturated; red: it touches the border or its undistortion
/// failed. Whatever falls outside the image is left out.
void draw_overlay(const GreyPixels& image, std::span<const shaders::BlobRecord> blobs,
                  const OverlayOptions& options, std::vector<std::uint8_t>& rgb);

}  // namespace glint
