// SPDX-License-Identifier: MIT
// Step 6: the sums of a blob's components, moved to the first one's tile and added, become a BlobRecord.

struct BlobSums {
  uint area, grey, weight, peak;
  uvec2 x, y, xx, xy, yy;  // exact, about the first pixel of the root's tile
  uvec4 box;               // x_min, y_min, x_max, y_max
};

ivec2 tile_origin(uint tile) { return ivec2(int((tile & 0xffffu) * kTileWidth), int((tile >> 16) * kTileHeight)); }

void add_component(inout BlobSums blob, uvec4 first, uvec4 second, ivec2 origin) {
  uint weight = first.y >> 16, x = first.z, y = first.w;
  blob.area += first.x & 0xffu;
  blob.peak = max(blob.peak, (first.x >> 8) & 0xffu);
  blob.grey += first.y & 0xffffu;
  blob.weight += weight;
  ivec2 corner = tile_origin(second.w);
  uvec2 at = uvec2(corner);
  uint box = first.x >> 16;
  blob.box.xy = min(blob.box.xy, at + uvec2(box & 15u, (box >> 8) & 7u));
  blob.box.zw = max(blob.box.zw, at + uvec2((box >> 4) & 15u, (box >> 11) & 7u));

  ivec2 d = corner - origin;
  uvec2 w_dx = wide_multiply(weight, d.x), w_dy = wide_multiply(weight, d.y);
  uvec2 wx = wide_add(uvec2(x, 0u), w_dx);  // sum w (x + dx)
  uvec2 wy = wide_add(uvec2(y, 0u), w_dy);
  blob.x = wide_add(blob.x, wx);
  blob.y = wide_add(blob.y, wy);
  // sum w (x + dx)^2 = sum w x^2 + dx (sum w x + sum w (x + dx))
  blob.xx = wide_add(blob.xx, wide_add(uvec2(second.x, 0u), wide_multiply(wide_add(uvec2(x, 0u), wx), d.x)));
  blob.yy = wide_add(blob.yy, wide_add(uvec2(second.z, 0u), wide_multiply(wide_add(uvec2(y, 0u), wy), d.y)));
  // sum w (x + dx) (y + dy) = sum w x y + dy sum w x + dx sum w (y + dy)
  uvec2 xy = wide_add(uvec2(second.y, 0u), wide_multiply(x, d.y));
  blob.xy = wide_add(blob.xy, wide_add(xy, wide_multiply(wy, d.x)));
}

// k + r / weight = sum / weight, k a whole number and |r| <= weight: the quotient without float's cancellation.
float quotient(uvec2 sum, uint weight, out int whole) {
  whole = int(round(wide_to_float(sum) / float(weight)));
  uvec2 rest = wide_add(sum, wide_negate(wide_multiply(weight, whole)));
  return wide_to_float(rest) / float(weight);
}

// Root number i of the camera.
void emit_blob(uint camera, uint i) {
  uint base = cameras[camera].component_base;
  uint root = base + roots[base + i];
  uvec4 first = imageLoad(sums, int(2u * root)), second = imageLoad(sums, int(2u * root + 1u));
  ivec2 origin = tile_origin(second.w);
  BlobSums blob = BlobSums(0u, 0u, 0u, 0u, uvec2(0u), uvec2(0u), uvec2(0u), uvec2(0u), uvec2(0u),
                           uvec4(0xffffffffu, 0xffffffffu, 0u, 0u));
  uint next = heads[root];
  heads[root] = 0u;  // as the next frame set wants it
  add_component(blob, first, second, origin);
  // Tested at the top: in Mesa's CPU driver what the body of a loop computed goes on changing, for lanes that have left it,
  // as long as others turn; only what stands when a turn begins is safe.
  while (next != 0u && spend_turn()) {
    uint at = base + next - 1u;
    add_component(blob, imageLoad(sums, int(2u * at)), imageLoad(sums, int(2u * at + 1u)), origin);
    next = chain[at];
  }
  bool cut = !has_turns();
  if (cut) atomicOr(counters[camera].flags, kCounterChainTooLong);

  if (cut || blob.area < max(min_area_px, 1u) || blob.area > max_area_px) return;
  uint weight = blob.weight;
  int kx, ky;
  vec2 rest = vec2(quotient(blob.x, weight, kx), 0.0);
  rest.y = quotient(blob.y, weight, ky);
  // Second moments about the whole pixel (kx, ky): exact integers, then a small correction.
  uvec2 w_kx = wide_multiply(weight, kx), w_ky = wide_multiply(weight, ky);
  uvec2 xx = wide_add(blob.xx, wide_multiply(wide_add(w_kx, wide_multiply(blob.x, -2)), kx));
  uvec2 yy = wide_add(blob.yy, wide_multiply(wide_add(w_ky, wide_multiply(blob.y, -2)), ky));
  uvec2 xy = wide_add(wide_add(blob.xy, wide_multiply(blob.x, -ky)), wide_multiply(wide_add(w_ky, wide_negate(blob.y)), kx));
  vec3 moments = vec3(wide_to_float(xx), wide_to_float(xy), wide_to_float(yy)) / float(weight);
  vec3 variance = moments - vec3(rest.x * rest.x, rest.x * rest.y, rest.y * rest.y);

  vec2 centre = vec2(ivec2(kx, ky) + origin) + rest;
  Lens lens = Lens(vec2(cameras[camera].fx_px, cameras[camera].fy_px), vec2(cameras[camera].cx_px, cameras[camera].cy_px),
                   cameras[camera].k1, cameras[camera].k2, cameras[camera].p1, cameras[camera].p2, cameras[camera].k3);
  bool invertible;
  vec2 undistorted = undistort_blob(lens, centre, variance, invertible);

  bool on_border = blob.box.x == 0u || blob.box.y == 0u || blob.box.z + 1u == cameras[camera].width_px ||
                   blob.box.w + 1u == cameras[camera].height_px;
  uint flags = (invertible ? 0u : kBlobNotInvertible) | (blob.peak == 255u ? kBlobSaturated : 0u) |
               (on_border ? kBlobOnBorder : 0u);
  uint n = atomicAdd(counters[camera].blobs, 1u);
  if (n < max_blobs) {
    blobs[camera * max_blobs + n] =
        BlobRecord(camera, flags, blob.area, blob.grey, weight, blob.peak, blob.box.x, blob.box.y, blob.box.z, blob.box.w,
                   centre.x, centre.y, undistorted.x, undistorted.y, variance.x, variance.y, variance.z, 0u, 0u, 0u);
  }
}
