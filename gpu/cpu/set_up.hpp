// SPDX-License-Identifier: MIT
// What both CPU detectors demand of cameras, options, limits and images.
#pragma once

#include <cstddef>
#include <span>
#include <string>

#include "gpu/detector.hpp"

namespace glint::gpu {

/// Throws Error when a detector cannot be made for these cameras with these options.
void check_set_up(std::span<const CameraFormat> cameras, const DetectorOptions& options);

/// Throws Error when this is no limit image for this camera, or sets are in flight.
void check_limit(std::span<const CameraFormat> cameras, std::uint32_t camera, std::size_t limit_bytes,
                 std::size_t in_flight);

/// BadImage, with the reason in `problem`, unless every image is missing or fits its camera. `problem` must
/// have room for kProblemBytes, so that nothing is allocated here.
inline constexpr std::size_t kProblemBytes = 200;
RunStatus check_images(std::span<const CameraFormat> cameras, std::span<const ImageView> images,
                       std::string& problem) noexcept;

}  // namespace glint::gpu
