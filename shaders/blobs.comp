#version 450
// SPDX-License-Identifier: MIT
// In: frames, limit images, candidate tiles. Out: one BlobRecord per 8-connected component.
// Reference: gpu/cpu/reference.cpp.
// Six steps: sum each tile; divide tiles that hold several components; join tiles to one neighbour; join the pairs that
// this leaves; gather components by blob; centroids. GLINT_STEP 0 runs all six with one workgroup per camera, for cameras
// with at most kFusedTiles candidates, few of them divided; the others go through GLINT_STEP 1 to 6, which share each list out to workgroups.
// Counters are zero, and the heads of the lists of components too, before and after a set.
#extension GL_GOOGLE_include_directive : require
#include "shaders/interface/blob_record.h"
#include "shaders/interface/params.h"

layout(local_size_x_id = 0) in;
layout(constant_id = 3) const uint kFusedTiles = 2048u;

layout(push_constant) uniform Options {
  uint min_area_px;
  uint max_area_px;
  uint max_blobs;
};

#define STEP(n) (GLINT_STEP == 0 || GLINT_STEP == n)
// Synchronization validation only sees a hazard between dispatches where one side is qualified: each step says exactly what
// it does with each buffer. READS(n): in step n it is read only, and so on.
#if GLINT_STEP == 0
#define WRITTEN coherent
#define READ coherent
#else
#define WRITTEN writeonly
#define READ readonly
#endif

layout(binding = 0, std140) uniform Cameras { CameraParams cameras[kMaxCameraCount]; };
layout(binding = 1) uniform usamplerBuffer frames;
layout(binding = 2) uniform usamplerBuffer limits;
layout(binding = 4, std430) coherent buffer Counters {
  DispatchSizes sizes;
  CameraCounters counters[];
};
#if STEP(1) || STEP(2) || STEP(3)
layout(binding = 5, std430) readonly buffer TileList { uint tile_list[]; };  // x | y << 16
#endif

// component.glsl says what they hold
#if STEP(1)
layout(binding = 6, rgba32ui) WRITTEN uniform uimageBuffer links;
layout(binding = 7, rgba32ui) WRITTEN uniform uimageBuffer sums;
#elif GLINT_STEP == 2
layout(binding = 6, rgba32ui) writeonly uniform uimageBuffer links;
layout(binding = 7, rgba32ui) coherent uniform uimageBuffer sums;
#elif GLINT_STEP == 3 || GLINT_STEP == 4
layout(binding = 6, rgba32ui) readonly uniform uimageBuffer links;
#elif GLINT_STEP == 6
layout(binding = 7, rgba32ui) readonly uniform uimageBuffer sums;
#endif

#if GLINT_STEP == 2 || GLINT_STEP == 3
layout(binding = 8, std430) writeonly buffer Parents { uint parents[]; };
#elif STEP(4) || STEP(5)
layout(binding = 8, std430) coherent buffer Parents { uint parents[]; };
#endif
// A second, writeonly view of what a step both reads and writes: synchronization validation takes a plain buffer block for
// reading only, and would not notice a missing barrier behind it.
#if GLINT_STEP == 4 || GLINT_STEP == 5
layout(binding = 8, std430) coherent writeonly buffer ParentsOut { uint parents_out[]; };
#else
#define parents_out parents
#endif

const uint kNoComponent = 0xffffffffu;  // as a parent: of a place in the tile list that has no component of its own

#if STEP(5) || STEP(6)
layout(binding = 9, std430) coherent buffer Heads { uint heads[]; };  // of a root: number + 1 of a component in its list
#endif
#if STEP(5)
layout(binding = 10, std430) WRITTEN buffer Chain { uint chain[]; };  // of a component: the next one in the list
layout(binding = 13, std430) WRITTEN buffer Roots { uint roots[]; };
#elif STEP(6)
layout(binding = 10, std430) readonly buffer Chain { uint chain[]; };
layout(binding = 13, std430) readonly buffer Roots { uint roots[]; };
#endif
#if STEP(1)
layout(binding = 11, std430) WRITTEN buffer Divided { uint divided[]; };  // place in the tile list
#elif STEP(2)
layout(binding = 11, std430) readonly buffer Divided { uint divided[]; };
#endif
#if STEP(3)
layout(binding = 12, std430) WRITTEN buffer Pairs { uint pairs[]; };  // tile | direction << 30
#elif STEP(4)
layout(binding = 12, std430) readonly buffer Pairs { uint pairs[]; };
#endif
#if STEP(6)
layout(binding = 14, std430) writeonly buffer Blobs { BlobRecord blobs[]; };
#endif

#include "shaders/lib/bit_tile.glsl"
#include "shaders/lib/packed_bytes.glsl"
#include "shaders/lib/component.glsl"
#include "shaders/lib/turns.glsl"
#if STEP(1) || STEP(2)
#include "shaders/lib/tile_sums.glsl"
#endif
#if STEP(1)
#include "shaders/lib/tile_components.glsl"
#endif
#if STEP(2)
#include "shaders/lib/divided_tiles.glsl"
#endif
#if STEP(3)
#include "shaders/lib/join_tiles.glsl"
#endif
#if STEP(4) || STEP(5)
#include "shaders/lib/union_find.glsl"
#endif
#if STEP(4)
#include "shaders/lib/join_pairs.glsl"
#endif
#if STEP(5)
#include "shaders/lib/blob_lists.glsl"
#endif
#if STEP(6)
#include "shaders/lib/wide.glsl"
#include "shaders/lib/undistort.glsl"
#include "shaders/lib/emit_blobs.glsl"
#endif

uint extra_components_used(uint camera) { return min(counters[camera].extra, cameras[camera].extra_components); }

#if GLINT_STEP == 0
void meet() {
  memoryBarrier();
  barrier();
  memoryBarrier();  // barrier() alone orders shared memory only
}

void main() {
  uint camera = gl_WorkGroupID.x;
  uint tiles = counters[camera].tiles;
  uint self = gl_LocalInvocationID.x;
  uint step = gl_WorkGroupSize.x;
  if (tiles > kFusedTiles) tiles = 0u;  // then the other counters are still zero
  for (uint i = self; i < tiles; i += step) find_tile_component(camera, i);
  meet();
  // Divided tiles cost turns of loops without end, and a CPU driver stops an invocation that takes too many (turns.glsl).
  uint several = counters[camera].divided;
  bool too_divided = several > kFusedTiles / 16u;
  meet();  // all have read the counter
  if (too_divided) {
    if (self == 0u) {
      counters[camera].divided = 0u;
      counters[camera].too_divided = 1u;
      atomicMax(sizes.tiles.x, (tiles + kSplitGroup - 1u) / kSplitGroup);
    }
    tiles = 0u;
    several = 0u;
  }
  for (uint i = self; i < several; i += step) divide_tile(camera, i);
  meet();
  for (uint i = self; i < tiles; i += step) join_tile(camera, i);
  meet();
  uint pair_count = counters[camera].pairs;
  for (uint i = self; i < pair_count; i += step) join_pair(camera, i);
  meet();
  uint components = tiles + extra_components_used(camera);
  for (uint i = self; i < components; i += step) enter_list(camera, i, tiles);
  meet();
  uint root_count = counters[camera].roots;
  for (uint i = self; i < root_count; i += step) emit_blob(camera, i);
}
#else
void main() {
  uint camera = gl_WorkGroupID.y;
  uint tiles = counters[camera].tiles;
  if (tiles <= kFusedTiles && counters[camera].too_divided == 0u) return;
  uint self = gl_GlobalInvocationID.x;
#if GLINT_STEP == 1
  if (self < tiles) find_tile_component(camera, self);
#elif GLINT_STEP == 2
  if (self < counters[camera].divided) divide_tile(camera, self);
#elif GLINT_STEP == 3
  if (self < tiles) join_tile(camera, self);
#elif GLINT_STEP == 4
  if (self < counters[camera].pairs) join_pair(camera, self);
#elif GLINT_STEP == 5
  // There may be more components than tiles: the dispatch is sized by tiles.
  uint components = tiles + extra_components_used(camera);
  uint step = gl_NumWorkGroups.x * gl_WorkGroupSize.x;
  for (uint i = self; i < components; i += step) enter_list(camera, i, tiles);
#else
  if (self < counters[camera].roots) emit_blob(camera, self);
#endif
}
#endif
