// SPDX-License-Identifier: MIT
// Step 1: threshold one tile, find its 8-connected components and sum each one.

// The bright pixels of a tile: value > limit.
uvec4 bright_pixels(uint frame, uint stride, uint limit, uint limit_stride) {
  uvec4 tile = uvec4(0u);
  for (uint row = 0u; row < kTileHeight; row++) {
    uvec4 values = texelFetch(frames, int(frame + row * stride));
    uvec4 bounds = texelFetch(limits, int(limit + row * limit_stride));
    uint bits = flags_to_bits(greater_bytes(values.x, bounds.x)) | (flags_to_bits(greater_bytes(values.y, bounds.y)) << 4) |
                (flags_to_bits(greater_bytes(values.z, bounds.z)) << 8) |
                (flags_to_bits(greater_bytes(values.w, bounds.w)) << 12);
    tile[row >> 1] |= bits << ((row & 1u) * 16u);
  }
  return tile;
}

struct RowSums {
  uint grey, weight, x, x2, peak;
};

// Adds four pixels, of which `bits` are in the component and the first stands in column x.
void add_word(inout RowSums row, uint bits, uint values, uint bounds, uint x) {
  uint mask = bits_to_bytes(bits & 15u);
  uint value = values & mask;
  uint w = value - (bounds & mask);  // no borrow: value > limit in every masked byte
  uint v0 = value & 255u, v1 = (value >> 8) & 255u, v2 = (value >> 16) & 255u, v3 = value >> 24;
  uint w0 = w & 255u, w1 = (w >> 8) & 255u, w2 = (w >> 16) & 255u, w3 = w >> 24;
  uint s0 = w0 + w1 + w2 + w3;
  uint s1 = w1 + 2u * w2 + 3u * w3;
  row.grey += v0 + v1 + v2 + v3;
  row.peak = max(max(row.peak, max(v0, v1)), max(v2, v3));
  row.weight += s0;
  row.x += x * s0 + s1;
  row.x2 += x * x * s0 + 2u * x * s1 + w1 + 4u * w2 + 9u * w3;
}

void sum_component(uint slot, uvec4 component, uint frame, uint stride, uint limit, uint limit_stride, ivec2 origin) {
  uint area = 0u, grey = 0u, weight = 0u, peak = 0u, x1 = 0u, y1 = 0u, x2 = 0u, xy = 0u, y2 = 0u;
  uint columns = 0u, rows = 0u;
  for (uint row = 0u; row < kTileHeight; row++) {
    uint bits = tile_row(component, row);
    columns |= bits;
    rows |= bits != 0u ? 1u << row : 0u;
    area += uint(bitCount(bits));
    uvec4 values = texelFetch(frames, int(frame + row * stride));
    uvec4 bounds = texelFetch(limits, int(limit + row * limit_stride));
    RowSums r = RowSums(0u, 0u, 0u, 0u, 0u);
    add_word(r, bits, values.x, bounds.x, 0u);
    add_word(r, bits >> 4, values.y, bounds.y, 4u);
    add_word(r, bits >> 8, values.z, bounds.z, 8u);
    add_word(r, bits >> 12, values.w, bounds.w, 12u);
    grey += r.grey;
    peak = max(peak, r.peak);
    weight += r.weight;
    x1 += r.x;
    x2 += r.x2;
    y1 += row * r.weight;
    xy += row * r.x;
    y2 += row * row * r.weight;
  }
  sums[sum_index(kArea, slot)] = area;
  sums[sum_index(kGreySum, slot)] = grey;
  sums[sum_index(kWeight, slot)] = weight;
  sums[sum_index(kPeak, slot)] = peak;
  sums[sum_index(kXMin, slot)] = uint(origin.x + findLSB(columns));
  sums[sum_index(kYMin, slot)] = uint(origin.y + findLSB(rows));
  sums[sum_index(kXMax, slot)] = uint(origin.x + findMSB(columns));
  sums[sum_index(kYMax, slot)] = uint(origin.y + findMSB(rows));
  sums[sum_index(kX, slot)] = x1;
  sums[sum_index(kY, slot)] = y1;
  sums[sum_index(kXX, slot)] = x2;
  sums[sum_index(kXY, slot)] = xy;
  sums[sum_index(kYY, slot)] = y2;
  for (uint field = kX; field <= kYY; field++) sums[sum_index(field + kHigh, slot)] = 0u;
}

// Tile number i of the camera's list: slot i takes its first component (none: area 0), further ones take extra slots.
void find_tile_components(uint camera, uint i) {
  uint tiles_x = cameras[camera].tiles_x;
  uint tile = tile_list[cameras[camera].tile_base + i];
  uint tile_x = tile % tiles_x, tile_y = tile / tiles_x;
  uint stride = cameras[camera].stride_texels;
  uint frame = cameras[camera].frame_texel + tile_y * kTileHeight * stride + tile_x;
  uint limit = cameras[camera].limit_texel + tile_y * kTileHeight * tiles_x + tile_x;
  uint slot_base = cameras[camera].slot_base;
  uint first_extra = tiles_x * cameras[camera].tiles_y;
  uint extra_slots = cameras[camera].extra_slots;
  ivec2 origin = ivec2(int(tile_x * kTileWidth), int(tile_y * kTileHeight));

  uvec4 rest = bright_pixels(frame, stride, limit, tiles_x);
  uint local = i;
  bool more;
  do {
    uvec4 component = first_component(rest);
    rest &= ~component;
    more = rest != uvec4(0u);
    uint next = 0u;
    if (more) {
      uint extra = atomicAdd(counters[camera].extra, 1u);
      if (extra < extra_slots) {
        next = first_extra + extra + 1u;
      } else {
        atomicOr(counters[camera].flags, kCounterSlotsFull);
        more = false;
      }
    }
    uint slot = slot_base + local;
    parents[slot] = slot;
    links[slot] = uvec4(tile_row(component, 0u) | (tile_row(component, kTileHeight - 1u) << 16),
                        tile_column(component, 0u) | (tile_column(component, kTileWidth - 1u) << 16), next,
                        tile_x | (tile_y << 16));
    sum_component(slot, component, frame, stride, limit, tiles_x, origin);
    local = next - 1u;
  } while (more);
}
