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

uvec4 joined_rows(uint texel, uint stride) {
  uvec4 joined = texelFetch(frames, int(texel));
  for (uint row = 1u; row < kTileHeight; row++) joined |= texelFetch(frames, int(texel + row * stride));
  return joined;
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
      uvec4 rows = joined_rows(column + tile_y * kTileHeight * stride, stride);
      joined = rows.x | rows.y | rows.z | rows.w;
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
