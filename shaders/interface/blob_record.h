// SPDX-License-Identifier: MIT
// One blob as every detector back end returns it; the same bytes on the GPU and on the host.
#ifndef GLINT_SHADERS_BLOB_RECORD_H
#define GLINT_SHADERS_BLOB_RECORD_H
#ifdef __cplusplus
#include <cstdint>
namespace glint::shaders {
using uint = std::uint32_t;
#endif

// A blob is an 8-connected component of the pixels whose value is greater than the limit image.
// Weights are (value - limit). Pixels: (0,0) is the centre of the top-left pixel.
struct BlobRecord {
  uint camera;
  uint flags;     // kBlob... bits below
  uint area_px;   // number of pixels
  uint sum;       // grey sum: sum of the pixel values (at most 255 * 2^24, fits)
  uint weight;    // sum of (value - limit)
  uint peak;      // largest pixel value
  uint x_min_px;  // bounding box, inclusive
  uint y_min_px;
  uint x_max_px;
  uint y_max_px;
  float x_px;  // weighted centroid, raw (distorted) image
  float y_px;
  float x_undist;    // the same after undistortion, in the z = 1 plane of the camera, with the
  float y_undist;    // second-order term (the mean of the undistorted pixels, not the undistorted mean)
  float var_xx_px2;  // weighted second central moments, raw image
  float var_xy_px2;
  float var_yy_px2;
  uint reserved0;
  uint reserved1;
  uint reserved2;
};

#ifdef __cplusplus
// The lens model cannot be inverted at this point (it folds over): x_undist, y_undist are only the
// nearest point that could be reached.
inline constexpr uint kBlobNotInvertible = 1u;
// Some pixel is 255: the profile is clipped.
inline constexpr uint kBlobSaturated = 2u;
// The blob touches the border of the image: its centroid is biased.
inline constexpr uint kBlobOnBorder = 4u;
static_assert(sizeof(BlobRecord) == 80);
}  // namespace glint::shaders
#else
const uint kBlobNotInvertible = 1u;
const uint kBlobSaturated = 2u;
const uint kBlobOnBorder = 4u;
#endif
#endif
