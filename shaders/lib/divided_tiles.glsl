// SPDX-License-Identifier: MIT
// Step 2: the components of a tile that has several.

void add_masked_row(inout TileSums s, uint bits, int frame, int limit) {
  add_row(s, texelFetch(frames, frame), texelFetch(limits, limit), bits_to_bytes(bits));
}

void add_masked_rows(inout TileSums s, uint two_rows, int frame, int stride, int limit) {
  add_masked_row(s, two_rows >> 16, frame + stride, limit + 1);
  add_masked_row(s, two_rows & 0xffffu, frame, limit);
}

// A number for a further component; 0 if there is none left.
uint new_number(uint camera) {
  uint extra = atomicAdd(counters[camera].extra, 1u);
  bool fits = extra < cameras[camera].extra_components;
  if (!fits) atomicOr(counters[camera].flags, kCounterComponentsFull);
  return fits ? cameras[camera].tiles_x * cameras[camera].tiles_y + extra : 0u;
}

void divide_tile(uint camera, uint n) {
  uint i = divided[cameras[camera].tile_base + n];
  uint entry = tile_list[cameras[camera].tile_base + i];
  uint tile_x = entry & 0xffffu, tile_y = entry >> 16;
  int stride = int(cameras[camera].stride_texels);
  int frame = int(cameras[camera].frame_texel + tile_x) + int(tile_y * kTileHeight) * stride;
  uint tile_index = tile_x + tile_y * cameras[camera].tiles_x;
  int limit = int((cameras[camera].tile_base + tile_index) * kTileHeight);
  uint base = cameras[camera].component_base;

  uvec4 rest = imageLoad(sums, int(2u * (base + i)));
  uint number = new_number(camera);
  uvec4 link = make_link(rest, number, number != 0u ? cameras[camera].stamp : 0u);  // the borders of all components
  imageStore(links, int(base + tile_index), uvec4(link.x, link.y | kDivided, link.zw));
  while (number != 0u) {
    uvec4 component = first_component(rest);
    rest &= ~component;
    uint next = 0u;
    if (rest != uvec4(0u)) next = new_number(camera);
    TileSums s = no_sums();
    add_masked_rows(s, component.w, frame + 6 * stride, stride, limit + 6);
    add_masked_rows(s, component.z, frame + 4 * stride, stride, limit + 4);
    add_masked_rows(s, component.y, frame + 2 * stride, stride, limit + 2);
    add_masked_rows(s, component.x, frame, stride, limit);
    uvec4 first, second;
    finish_sums(s, component, entry, first, second);
    imageStore(sums, int(2u * (base + number)), first);
    imageStore(sums, int(2u * (base + number) + 1u), second);
    imageStore(links, int(base + number), make_link(component, next, 0u));
    parents[base + number] = number;
    number = next;
  }
}
