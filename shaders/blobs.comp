#version 450
// SPDX-License-Identifier: MIT
// In: frames, limit images, candidate tiles. Out: one BlobRecord per 8-connected component.
// Reference: gpu/cpu/reference.cpp.
// Four steps: components inside a tile, joining across tiles, summing into the roots, centroids.
// GLINT_STEP 0 runs all four with one workgroup per camera, for cameras with at most kFusedTiles candidates;
// the others are left for GLINT_STEP 1 to 4, one invocation per tile. Counters are zero before and after a set.
#extension GL_GOOGLE_include_directive : require
#include "shaders/interface/blob_record.h"
#include "shaders/interface/params.h"

layout(local_size_x_id = 0) in;
layout(constant_id = 1) const uint kFusedTiles = 2048u;

layout(push_constant) uniform Options {
  uint min_area_px;
  uint max_area_px;
  uint max_blobs;
  uint slots;  // of all cameras together: the distance between two fields of `sums`
};

// Synchronization validation only sees a hazard between dispatches where one side is qualified; each
// step says exactly what it does with each buffer.
layout(binding = 0, std140) uniform Cameras { CameraParams cameras[kMaxCameraCount]; };
layout(binding = 1) uniform usamplerBuffer frames;
layout(binding = 2) uniform usamplerBuffer limits;
layout(binding = 4, std430) coherent buffer Counters { CameraCounters counters[]; };
layout(binding = 5, std430) readonly buffer TileList { uint tile_list[]; };
#if GLINT_STEP != 4
layout(binding = 7, std430)
#if GLINT_STEP == 0 || GLINT_STEP == 2
    coherent
#elif GLINT_STEP == 1
    writeonly
#else
    readonly
#endif
    buffer Parents { uint parents[]; };
#endif
layout(binding = 8, std430)
#if GLINT_STEP == 0
    coherent
#elif GLINT_STEP == 1
    writeonly
#else
    readonly
#endif
    buffer Links { uvec4 links[]; };  // border rows, border columns, next slot of the tile + 1, tile
layout(binding = 9, std430)
#if GLINT_STEP == 0 || GLINT_STEP == 3
    coherent
#elif GLINT_STEP == 1
    writeonly
#elif GLINT_STEP == 4
    readonly
#endif
    buffer Sums { uint sums[]; };
// A second, writeonly view of what a step both reads and writes: synchronization validation takes a plain buffer block
// for reading only, and would not notice a missing barrier behind it.
#if GLINT_STEP == 2
layout(binding = 7, std430) coherent writeonly buffer ParentsOut { uint parents_out[]; };
#else
#define parents_out parents
#endif
#if GLINT_STEP == 0 || GLINT_STEP == 3
layout(binding = 12, std430)
#if GLINT_STEP == 0
    coherent
#else
    writeonly
#endif
    buffer Roots { uint roots[]; };
#elif GLINT_STEP == 4
layout(binding = 12, std430) readonly buffer Roots { uint roots[]; };
#endif
#if GLINT_STEP == 0 || GLINT_STEP == 2
layout(binding = 6, std430)
#if GLINT_STEP == 0
    coherent
#else
    readonly
#endif
    buffer TileMap { uint tile_map[]; };
#elif GLINT_STEP == 4
layout(binding = 6, std430) writeonly buffer TileMap { uint tile_map[]; };
#endif
#if GLINT_STEP == 0
layout(binding = 11, std430) writeonly buffer Header { CameraCounters header[]; };
#endif
#if GLINT_STEP == 0 || GLINT_STEP == 4
layout(binding = 10, std430) writeonly buffer Blobs { BlobRecord blobs[]; };
#endif

#include "shaders/lib/bit_tile.glsl"
#include "shaders/lib/packed_bytes.glsl"
#include "shaders/lib/wide.glsl"
#include "shaders/lib/component_sums.glsl"
#if GLINT_STEP == 0 || GLINT_STEP == 1
#include "shaders/lib/tile_components.glsl"
#endif
#if GLINT_STEP == 0 || GLINT_STEP == 2 || GLINT_STEP == 3
#include "shaders/lib/union_find.glsl"
#endif
#if GLINT_STEP == 0 || GLINT_STEP == 2
#include "shaders/lib/join_tiles.glsl"
#endif
#if GLINT_STEP == 0 || GLINT_STEP == 3
#include "shaders/lib/sum_roots.glsl"
#endif
#if GLINT_STEP == 0 || GLINT_STEP == 4
#include "shaders/lib/undistort.glsl"
#include "shaders/lib/emit_blobs.glsl"
#endif

#if GLINT_STEP == 0
void meet() {
  memoryBarrierBuffer();
  barrier();
  memoryBarrierBuffer();  // barrier() alone orders shared memory only
}

void main() {
  uint camera = gl_WorkGroupID.x;
  uint tiles = counters[camera].tiles;
  uint self = gl_LocalInvocationID.x;
  uint step = gl_WorkGroupSize.x;
  bool large = tiles > kFusedTiles;
  if (large) tiles = 0u;
  for (uint i = self; i < tiles; i += step) find_tile_components(camera, i);
  meet();
  for (uint i = self; i < tiles; i += step) join_tile(camera, i);
  meet();
  for (uint i = self; i < tiles; i += step) sum_into_roots(camera, i);
  meet();
  for (uint i = self; i < tiles; i += step) clear_tile(camera, i);
  uint root_count = large ? 0u : counters[camera].roots;
  for (uint i = self; i < root_count; i += step) emit_blob(camera, i);
  meet();
  if (self == 0u) {
    header[camera].tiles = counters[camera].tiles;
    header[camera].blobs = counters[camera].blobs;
    header[camera].flags = counters[camera].flags;
    if (!large) {
      counters[camera].tiles = 0u;
      counters[camera].extra = 0u;
      counters[camera].roots = 0u;
      counters[camera].blobs = 0u;
      counters[camera].flags = 0u;
    }
  }
}
#else
void main() {
  uint camera = gl_WorkGroupID.y;
  uint tiles = counters[camera].tiles;
  if (tiles <= kFusedTiles) return;
  uint i = gl_GlobalInvocationID.x;
#if GLINT_STEP == 1
  if (i < tiles) find_tile_components(camera, i);
#elif GLINT_STEP == 2
  if (i < tiles) join_tile(camera, i);
#elif GLINT_STEP == 3
  if (i < tiles) sum_into_roots(camera, i);
#else
  if (i < tiles) clear_tile(camera, i);
  // There may be more roots than tiles: the dispatch is sized by tiles.
  uint root_count = counters[camera].roots;
  for (uint n = i; n < root_count; n += gl_NumWorkGroups.x * gl_WorkGroupSize.x) emit_blob(camera, n);
#endif
}
#endif
