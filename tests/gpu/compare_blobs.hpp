// SPDX-License-Identifier: MIT
// Are two lists of blobs the same, as exactly as detectors promise it?
#pragma once

#include <gtest/gtest.h>

#include <span>

#include "gpu/detector.hpp"
#include "tests/gpu/detector_cases.hpp"
#include "tests/gpu/test_images.hpp"

namespace glint::gpu::testing {

/// Integers equal, centroids and undistorted points within 0.001 px, second moments within 1e-3 relative.
/// The order of blobs is checked to be the promised one.
::testing::AssertionResult same_blobs(const CameraBlobs& expected, const CameraBlobs& actual,
                                      const Lens& lens);

/// Runs `detector` and the reference over one frame set and compares camera by camera. Images without
/// pixels stand for missing frames.
void expect_equal_to_reference(const DetectorCase& detector, std::span<const TestImage> images,
                               DetectorOptions options = {});

/// Sets each camera's limit image.
void set_limits(Detector& detector, std::span<const TestImage> images);

/// submit() and collect() of one set, both expected to succeed.
BlobBatch detect(Detector& detector, std::span<const ImageView> images);

}  // namespace glint::gpu::testing
