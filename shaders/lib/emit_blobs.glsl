// SPDX-License-Identifier: MIT
// Step 4: roots become BlobRecords; the tile map is left clear for the next frame set.

// k + r / weight = sum / weight, k a whole number and |r| <= weight: the quotient without float's cancellation.
float quotient(uvec2 sum, uint weight, out int whole) {
  whole = int(round(wide_to_float(sum) / float(weight)));
  uvec2 rest = wide_add(sum, wide_negate(wide_multiply(uvec2(weight, 0u), whole)));
  return wide_to_float(rest) / float(weight);
}

uvec2 wide_sum(uint field, uint slot) { return uvec2(sums[sum_index(field, slot)], sums[sum_index(field + kHigh, slot)]); }

// Root number i of the camera.
void emit_blob(uint camera, uint i) {
  uint slot = roots[cameras[camera].slot_base + i];
  uint tile = links[slot].w;
  uint area = sums[sum_index(kArea, slot)];
  if (area < max(min_area_px, 1u) || area > max_area_px) return;
  uint weight = sums[sum_index(kWeight, slot)];
  uvec2 sx = wide_sum(kX, slot), sy = wide_sum(kY, slot);
  int kx, ky;
  vec2 rest = vec2(quotient(sx, weight, kx), 0.0);
  rest.y = quotient(sy, weight, ky);
  // Second moments about the whole pixel (kx, ky): exact integers, then a small correction.
  uvec2 w = uvec2(weight, 0u);
  uvec2 xx = wide_add(wide_sum(kXX, slot), wide_multiply(wide_add(wide_multiply(w, kx), wide_multiply(sx, -2)), kx));
  uvec2 yy = wide_add(wide_sum(kYY, slot), wide_multiply(wide_add(wide_multiply(w, ky), wide_multiply(sy, -2)), ky));
  uvec2 xy = wide_add(wide_add(wide_sum(kXY, slot), wide_multiply(sx, -ky)),
                      wide_multiply(wide_add(wide_multiply(w, ky), wide_negate(sy)), kx));
  vec3 moments = vec3(wide_to_float(xx), wide_to_float(xy), wide_to_float(yy)) / float(weight);
  vec3 variance = moments - vec3(rest.x * rest.x, rest.x * rest.y, rest.y * rest.y);

  ivec2 origin = tile_origin(tile);
  vec2 centre = vec2(ivec2(kx, ky) + origin) + rest;
  Lens lens = Lens(vec2(cameras[camera].fx_px, cameras[camera].fy_px), vec2(cameras[camera].cx_px, cameras[camera].cy_px),
                   cameras[camera].k1, cameras[camera].k2, cameras[camera].p1, cameras[camera].p2, cameras[camera].k3);
  bool invertible;
  vec2 undistorted = undistort_blob(lens, centre, variance, invertible);

  uvec4 box = uvec4(sums[sum_index(kXMin, slot)], sums[sum_index(kYMin, slot)], sums[sum_index(kXMax, slot)],
                    sums[sum_index(kYMax, slot)]);
  uint peak = sums[sum_index(kPeak, slot)];
  bool on_border = box.x == 0u || box.y == 0u || box.z + 1u == cameras[camera].width_px ||
                   box.w + 1u == cameras[camera].height_px;
  uint flags = (invertible ? 0u : kBlobNotInvertible) | (peak == 255u ? kBlobSaturated : 0u) |
               (on_border ? kBlobOnBorder : 0u);
  uint n = atomicAdd(counters[camera].blobs, 1u);
  if (n < max_blobs) {
    blobs[camera * max_blobs + n] =
        BlobRecord(camera, flags, area, sums[sum_index(kGreySum, slot)], weight, peak, box.x, box.y, box.z, box.w,
                   centre.x, centre.y, undistorted.x, undistorted.y, variance.x, variance.y, variance.z, 0u, 0u, 0u);
  }
}

void clear_tile(uint camera, uint i) {
  uint tile_base = cameras[camera].tile_base;
  tile_map[tile_base + tile_list[tile_base + i]] = 0u;
}
