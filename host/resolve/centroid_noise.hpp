// SPDX-License-Identifier: MIT
// How well the weighted centroid of a blob is known.
#pragma once

#include <Eigen/Core>

#include "host/resolve/pixel_noise.hpp"
#include "shaders/interface/blob_record.h"

namespace glint {

/// Covariance of a blob's centroid in the raw image, for a blob that is the whole image of one marker: photon
/// noise, read noise and rounding of its pixels, and what the limit cuts off (decision 0021). Larger where
/// pixels are clipped. Hidden parts, neighbours and the border of the image are not in it.
Eigen::Matrix2d centroid_covariance_px2(const shaders::BlobRecord& blob, const PixelNoise& noise) noexcept;

}  // namespace glint
