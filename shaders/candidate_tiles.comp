#version 450
// SPDX-License-Identifier: MIT
// In: frames. Out: per camera, the list of tiles in which some pixel may exceed the limit image.
// Reference: none of its own; a tile too many only costs time, a tile too few shows in every blob test.
// Workgroup: one invocation owns one column of tiles and walks kTilesPerInvocation of them downwards.
#extension GL_GOOGLE_include_directive : require
#if GLINT_VOTE
#extension GL_KHR_shader_subgroup_vote : require
#endif
#include "shaders/interface/params.h"

layout(local_size_x_id = 0) in;
layout(constant_id = 1) const uint kTilesPerInvocation = 1u;

layout(binding = 0, std140) uniform Cameras { CameraParams cameras[kMaxCameraCount]; };
layout(binding = 1) uniform usamplerBuffer frames;
layout(binding = 3, std430) readonly buffer TileFloors { uint tile_floors[]; };  // smallest limit, four times
layout(binding = 4, std430) buffer Counters { CameraCounters counters[]; };
layout(binding = 5, std430) writeonly buffer TileList { uint tile_list[]; };
layout(binding = 6, std430) writeonly buffer TileMap { uint tile_map[]; };

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

  uint tile_x = gl_GlobalInvocationID.x;
  uint tile_y = gl_WorkGroupID.y * kTilesPerInvocation;
  uint end = min(tile_y + kTilesPerInvocation, cameras[camera].tiles_y);
  if (cameras[camera].present == 0u) end = 0u;
  bool mine = tile_x < tiles_x;
  uint column = cameras[camera].frame_texel + min(tile_x, tiles_x - 1u);

  while (tile_y < end) {
    // Search downwards. The bitwise or of a tile's pixels is at least its brightest one, so or <= floor
    // proves it dark. The lanes leave together: on a CPU driver one that waits costs as much as one that works.
    uint joined;
    bool hit;
    do {
      joined = joined_pixels(int(column + tile_y * kTileHeight * stride), int(stride));
      hit = mine && greater_bytes(joined, floor_splat) != 0u;
      tile_y++;
#if GLINT_VOTE
    } while (tile_y < end && !subgroupAny(hit));
#else
    } while (tile_y < end && !hit);
#endif
    if (hit) {
      uint tile = (tile_y - 1u) * tiles_x + tile_x;
      if (greater_bytes(joined, tile_floors[tile_base + tile]) != 0u) {
        uint slot = atomicAdd(counters[camera].tiles, 1u);
        tile_list[tile_base + slot] = tile;
        tile_map[tile_base + tile] = slot + 1u;
      }
    }
  }
}
