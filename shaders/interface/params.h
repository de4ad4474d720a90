// SPDX-License-Identifier: MIT
// What the host tells the shaders, one block per camera; and what the shaders count.
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
GLINT_CONST kSplitGroup = 64u;  // workgroup of the split steps of blobs.comp

// Per camera; the first block changes with every frame set, the rest does not.
struct CameraParams {
  uint stamp;          // 0: this camera has no frame in this set; else differs from set to set
  uint frame_texel;    // first texel (16 bytes) of the frame in the frame buffer
  uint stride_texels;  // from row to row
  uint floor_splat;    // smallest value of the limit image, in all four bytes

  uint width_px;
  uint height_px;
  uint tiles_x;
  uint tiles_y;

  uint tile_base;       // first entry in the arrays that have one entry per tile
  uint component_base;  // first entry in the arrays that have one entry per component: one for each tile ...
  uint extra_components;  // ... and behind those so many for tiles with several
  uint reserved0;

  float fx_px;
  float fy_px;
  float cx_px;
  float cy_px;

  float k1;
  float k2;
  float p1;
  float p2;

  float k3;
  float reserved1;
  float reserved2;
  float reserved3;
};

// Workgroups of the indirect dispatches: x counts up from 0, y and z stand.
struct DispatchSize {
  uint x, y, z;
};
struct DispatchSizes {
  DispatchSize fused;    // one workgroup per camera
  DispatchSize tiles;    // enough for the longest list of any camera that is too large for the fused step
  DispatchSize divided;  // the same for the other lists
  DispatchSize pairs;
  DispatchSize roots;
  uint padding[17];
};

// One cache line pair per camera: two workers that count for different cameras must not share a line.
struct CameraCounters {
  uint tiles;        // candidate tiles listed
  uint divided;      // of these, with several components
  uint extra;        // components of divided tiles
  uint pairs;        // neighbouring tiles listed to be joined the long way
  uint roots;        // blobs, listed for the last step
  uint blobs;        // of these, those that passed the area filter
  uint flags;        // kCounter... bits
  uint too_divided;  // 1: few candidate tiles, but the fused step left them to the split ones
  uint padding[24];
};

// Not every component could be stored: some blobs are missing or cut.
GLINT_CONST kCounterComponentsFull = 1u;
// A chain was longer than a shader may walk.
GLINT_CONST kCounterChainTooLong = 2u;

#ifdef __cplusplus
static_assert(sizeof(CameraParams) == 96);
static_assert(sizeof(DispatchSizes) == 128);
static_assert(sizeof(CameraCounters) == 128);
}  // namespace glint::shaders
#endif
#undef GLINT_CONST
#endif
