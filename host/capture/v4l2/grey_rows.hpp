// SPDX-License-Identifier: MIT
// Raw frames to grey pixels: the brightness out of a driver's buffer.
#pragma once

#include <cstddef>

#include "host/capture/grey_target.hpp"
#include "host/capture/v4l2/camera_formats.hpp"

namespace glint {

/// `from`: at least format.image_bytes. Not for MJPEG.
void copy_grey_rows(const std::byte* from, const AgreedFormat& format, const GreyTarget& target) noexcept;

}  // namespace glint
