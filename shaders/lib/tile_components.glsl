// SPDX-License-Identifier: MIT
// Step 1: threshold a tile and sum it, as if it held one component; tiles with several are listed for step 2.

uvec4 add_bright_row(inout TileSums s, int frame, int limit) {
  uvec4 values = texelFetch(frames, frame), bounds = texelFetch(limits, limit);
  uvec4 bright = greater_bytes(values, bounds);
  add_row(s, values, bounds, flags_to_bytes(bright));
  return bright;
}

// Two rows, the lower one first.
uint add_bright_rows(inout TileSums s, int frame, int stride, int limit) {
  uint lower = flags_to_bits(add_bright_row(s, frame + stride, limit + 1));
  return flags_to_bits(add_bright_row(s, frame, limit)) | (lower << 16);
}

void find_tile_component(uint camera, uint i) {
  uint entry = tile_list[cameras[camera].tile_base + i];
  uint tile_x = entry & 0xffffu, tile_y = entry >> 16;
  int stride = int(cameras[camera].stride_texels);
  int frame = int(cameras[camera].frame_texel + tile_x) + int(tile_y * kTileHeight) * stride;
  uint tile_index = tile_x + tile_y * cameras[camera].tiles_x;
  int limit = int((cameras[camera].tile_base + tile_index) * kTileHeight);
  TileSums s = no_sums();
  uvec4 tile;
  tile.w = add_bright_rows(s, frame + 6 * stride, stride, limit + 6);
  tile.z = add_bright_rows(s, frame + 4 * stride, stride, limit + 4);
  tile.y = add_bright_rows(s, frame + 2 * stride, stride, limit + 2);
  tile.x = add_bright_rows(s, frame, stride, limit);

  bool dark = tile == uvec4(0u);
  bool several = !dark && !is_one_piece(tile);
  uvec4 first, second;
  finish_sums(s, tile, entry, first, second);
  if (!dark) {
    int at = 2 * int(cameras[camera].component_base + i);
    imageStore(sums, at, several ? tile : first);  // a tile in pieces waits for step 2 in the place of its sums
    imageStore(sums, at + 1, second);
    imageStore(links, int(cameras[camera].component_base + tile_index), make_link(tile, i, cameras[camera].stamp));
  }
  if (several) {
    uint place = atomicAdd(counters[camera].divided, 1u);
    divided[cameras[camera].tile_base + place] = i;
#if GLINT_STEP == 1
    atomicMax(sizes.divided.x, place / kSplitGroup + 1u);
#endif
  }
}
