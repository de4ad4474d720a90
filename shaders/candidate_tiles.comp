#version 450
// SPDX-License-Identifier: MIT
// In: frames. Out: per camera, the list of tiles in which some pixel may exceed the limit image.
// Reference: none of its own; a tile too many only costs time, a tile too few shows in every blob test.
// Workgroup: invocations side by side take one row of tiles each time, and walk kStepsAcross of their own width to the
// right in each of kRowsDown rows of tiles.
#extension GL_GOOGLE_include_directive : require
#if GLINT_VOTE
#extension GL_KHR_shader_subgroup_vote : require
#endif
#include "shaders/interface/params.h"

layout(local_size_x_id = 0) in;
layout(constant_id = 1) const uint kStepsAcross = 1u;
layout(constant_id = 2) const uint kRowsDown = 1u;
layout(constant_id = 3) const uint kFusedTiles = 2048u;

layout(binding = 0, std140) uniform Cameras { CameraParams cameras[kMaxCameraCount]; };
layout(binding = 1) uniform usamplerBuffer frames;
layout(binding = 3, std430) readonly buffer TileFloors { uint tile_floors[]; };  // smallest limit, four times
layout(binding = 4, std430) buffer Counters {
  DispatchSizes sizes;
  CameraCounters counters[];
};
layout(binding = 5, std430) writeonly buffer TileList { uint tile_list[]; };  // x | y << 16

#include "shaders/lib/packed_bytes.glsl"

// Written out: Mesa's CPU driver pays more for a loop's turn than for a fetch.
uint joined_pixels(int texel, int stride) {
  uvec4 rows = texelFetch(frames, texel) | texelFetch(frames, texel + stride);
  rows |= texelFetch(frames, texel + 2 * stride) | texelFetch(frames, texel + 3 * stride);
  rows |= texelFetch(frames, texel + 4 * stride) | texelFetch(frames, texel + 5 * stride);
  rows |= texelFetch(frames, texel + 6 * stride) | texelFetch(frames, texel + 7 * stride);
  return rows.x | rows.y | rows.z | rows.w;
}

void main() {
  uint camera = gl_WorkGroupID.z;
  uint tiles_x = cameras[camera].tiles_x;
  uint stride = cameras[camera].stride_texels;
  uint tile_base = cameras[camera].tile_base;
  uint floor_splat = cameras[camera].floor_splat;

  uint lane = gl_LocalInvocationID.x;
  uint first_x = gl_WorkGroupID.x * gl_WorkGroupSize.x * kStepsAcross;
  uint end_x = min(first_x + gl_WorkGroupSize.x * kStepsAcross, tiles_x);
  uint y = gl_WorkGroupID.y * kRowsDown;
  uint end_y = min(y + kRowsDown, cameras[camera].tiles_y);
  if (cameras[camera].stamp == 0u || first_x >= tiles_x) end_y = 0u;
  uint frame = cameras[camera].frame_texel;

  uint listed = 0u;  // length of the list when this invocation last added to it
  uint x = first_x;  // of lane 0
  while (y < end_y) {
    // Search. The bitwise or of a tile's pixels is at least its brightest one, so or <= floor proves it dark. The lanes
    // leave together: on a CPU driver one that waits costs as much as one that works. Going right keeps to eight rows of
    // memory, which a CPU fetches ahead.
    uint joined, tile_x, tile_y;
    bool hit;
    do {
      tile_x = min(x + lane, tiles_x - 1u);
      tile_y = y;
      joined = joined_pixels(int(frame + y * kTileHeight * stride + tile_x), int(stride));
      hit = x + lane < end_x && greater_bytes(joined, floor_splat) != 0u;
      x += gl_WorkGroupSize.x;
      bool row_ends = x >= end_x;
      x = row_ends ? first_x : x;
      y += row_ends ? 1u : 0u;
#if GLINT_VOTE
    } while (y < end_y && !subgroupAny(hit));
#else
    } while (y < end_y && !hit);
#endif
    if (hit && greater_bytes(joined, tile_floors[tile_base + tile_y * tiles_x + tile_x]) != 0u) {
      uint place = atomicAdd(counters[camera].tiles, 1u);
      tile_list[tile_base + place] = tile_x | (tile_y << 16);
      listed = place + 1u;
    }
  }
  // The size of what follows; once per invocation, whoever added last knows the length.
  if (listed != 0u && listed <= kFusedTiles) sizes.fused.x = gl_NumWorkGroups.z;
  if (listed > kFusedTiles) atomicMax(sizes.tiles.x, (listed + kSplitGroup - 1u) / kSplitGroup);
}
