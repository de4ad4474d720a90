// SPDX-License-Identifier: MIT
// Step 3: add the sums of every component that is not a root to its root, moved to the root's tile; list the roots.

void add_wide(uint field, uint root, uvec2 value) {
  uint before = atomicAdd(sums[sum_index(field, root)], value.x);
  uint carry = before + value.x < before ? 1u : 0u;
  atomicAdd(sums[sum_index(field + kHigh, root)], value.y + carry);
}

void add_to_root(uint slot, uint root, uint tile, uint root_tile) {
  uint weight = sums[sum_index(kWeight, slot)];
  atomicAdd(sums[sum_index(kArea, root)], sums[sum_index(kArea, slot)]);
  atomicAdd(sums[sum_index(kGreySum, root)], sums[sum_index(kGreySum, slot)]);
  atomicAdd(sums[sum_index(kWeight, root)], weight);
  atomicMax(sums[sum_index(kPeak, root)], sums[sum_index(kPeak, slot)]);
  atomicMin(sums[sum_index(kXMin, root)], sums[sum_index(kXMin, slot)]);
  atomicMin(sums[sum_index(kYMin, root)], sums[sum_index(kYMin, slot)]);
  atomicMax(sums[sum_index(kXMax, root)], sums[sum_index(kXMax, slot)]);
  atomicMax(sums[sum_index(kYMax, root)], sums[sum_index(kYMax, slot)]);

  ivec2 d = tile_origin(tile) - tile_origin(root_tile);
  uint x = sums[sum_index(kX, slot)], y = sums[sum_index(kY, slot)];
  uvec2 w = uvec2(weight, 0u), wx = uvec2(x, 0u), wy = uvec2(y, 0u);
  uvec2 w_dx = wide_multiply(w, d.x), w_dy = wide_multiply(w, d.y);
  add_wide(kX, root, wide_add(wx, w_dx));
  add_wide(kY, root, wide_add(wy, w_dy));
  // sum w (x + dx)^2 = sum w x^2 + dx (2 sum w x + dx sum w)
  uvec2 xx = wide_multiply(wide_add(uvec2(2u * x, 0u), w_dx), d.x);
  uvec2 yy = wide_multiply(wide_add(uvec2(2u * y, 0u), w_dy), d.y);
  // sum w (x + dx) (y + dy) = sum w x y + dy sum w x + dx (sum w y + dy sum w)
  uvec2 xy = wide_add(wide_multiply(wx, d.y), wide_multiply(wide_add(wy, w_dy), d.x));
  add_wide(kXX, root, wide_add(uvec2(sums[sum_index(kXX, slot)], 0u), xx));
  add_wide(kXY, root, wide_add(uvec2(sums[sum_index(kXY, slot)], 0u), xy));
  add_wide(kYY, root, wide_add(uvec2(sums[sum_index(kYY, slot)], 0u), yy));
}

void sum_into_roots(uint camera, uint i) {
  uint slot_base = cameras[camera].slot_base;
  uint mine = i + 1u;
  while (mine != 0u) {
    uint slot = slot_base + mine - 1u;
    uvec4 link = links[slot];
    uint root = find_root(slot, camera);
    if (root != slot) {
      add_to_root(slot, root, link.w, links[root].w);
    } else {
      roots[slot_base + atomicAdd(counters[camera].roots, 1u)] = slot;
    }
    mine = link.z;
  }
}
