// SPDX-License-Identifier: MIT
// What the host tells the shaders: one block for the detector, one per camera, and the counters that they
// share.
#ifndef GLINT_SHADERS_PARAMS_H
#define GLINT_SHADERS_PARAMS_H
#ifdef __cplusplus
#include <cstdint>
namespace glint::shaders {
using uint = std::uint32_t;
#define GLINT_CONST inline constexpr uint
#else
#define GLINT_CONST const uint
#endif

// Images are cut into tiles of 16 x 8 pixels: 16 bytes are one texel of a frame row, 8 rows of 16 bits one
// uvec4.
GLINT_CONST kTileWidth = 16u;
GLINT_CONST kTileHeight = 8u;
GLINT_CONST kMaxCameraCount = 32u;

// Per camera; the first block changes with every frame set, the rest does not.
struct CameraParams {
  uint present;        // 0: this camera has no frame in this set
  uint frame_texel;    // first texel (16 bytes) of the frame in the frame buffer
  uint stride_texels;  // from row to row
  uint floor_splat;    // smallest value of the limit image, in all four bytes

  uint width_px;
  uint height_px;
  uint tiles_x;
  uint tiles_y;

  uint
      limit_texel;  // first texel of the limit image: tiles_x texels a row, tiles_y * 8 rows, padded with 255
  uint tile_base;   // first entry in the arrays that have one entry per tile
  uint slot_base;   // first entry in the arrays that have one entry per local component
  uint extra_slots;  // slots beyond one per tile

  float fx_px;
  float fy_px;
  float cx_px;
  float cy_px;

  float k1;
  float k2;
  float p1;
  float p2;

  float k3;
  float reserved0;
  float reserved1;
  float reserved2;
};

// One cache line pair per camera: two workers that count for different cameras must not share a line.
struct CameraCounters {
  uint tiles;  // candidate tiles listed
  uint extra;  // slots used beyond one per tile
  uint roots;  // components, listed for the last step
  uint blobs;  // blobs that passed the area filter
  uint flags;  // kCounter... bits
  uint padding[27];
};

// Not every component could be stored: some blobs are missing or cut.
GLINT_CONST kCounterSlotsFull = 1u;
// A union-find chain was longer than a shader may walk.
GLINT_CONST kCounterChainTooLong = 2u;

#ifdef __cplusplus
static_assert(sizeof(CameraParams) == 96);
static_assert(sizeof(CameraCounters) == 128);
}  // namespace glint::shaders
#endif
#undef GLINT_CONST
#endif
