// SPDX-License-Identifier: MIT
// The sums of a tile's bright pixels. Two columns share a word: no sum over 8 rows of bytes needs more than 16 bits, and
// y moments come from adding the running sums again and again instead of multiplying (rows go from the last to the first).

struct TileSums {
  uvec4 even, odd;      // per column: sum w; word j holds columns 4 j and 4 j + 2, or 4 j + 1 and 4 j + 3
  uvec4 y_even, y_odd;  // per column: sum w y
  uvec4 yy;             // sum w y (y + 1) / 2, spread over the halves
  uvec4 grey;           // sum of the values, spread over the halves
  uvec4 peak;           // largest value in the high half
};

TileSums no_sums() {
  return TileSums(uvec4(0u), uvec4(0u), uvec4(0u), uvec4(0u), uvec4(0u), uvec4(0u), uvec4(0u));
}

// The row above those that were added so far; `mask` has 0xff where a pixel counts, and there value > limit.
void add_row(inout TileSums s, uvec4 values, uvec4 bounds, uvec4 mask) {
  const uint kHalves = 0x00ff00ffu;
  s.y_even += s.even;
  s.y_odd += s.odd;
  s.yy += s.y_even + s.y_odd;
  uvec4 value = values & mask;
  uvec4 w = value - (bounds & mask);  // no borrow
  s.even += w & kHalves;
  s.odd += (w >> 8) & kHalves;
  uvec4 v_even = value & kHalves, v_odd = (value >> 8) & kHalves;
  s.grey += v_even + v_odd;
  s.peak = max(s.peak, max(max(v_even, v_odd), max(v_even << 16, v_odd << 16)));
}

uint lower(uint word) { return word & 0xffffu; }
uint upper(uint word) { return word >> 16; }
uint halves(uint word) { return lower(word) + upper(word); }

// sum of four words, and that weighted with 0, 1, 2, 3
uint added(uvec4 v) { return v.x + v.y + v.z + v.w; }
uint stepped(uvec4 v) { return v.y + 2u * v.z + 3u * v.w; }

// The two texels of a component (component.glsl).
void finish_sums(TileSums s, uvec4 component, uint tile, out uvec4 first, out uvec4 second) {
  uint c0e = added(s.even), c0o = added(s.odd);      // sum w of columns 0, 2 and 1, 3 modulo 4
  uint c1e = stepped(s.even), c1o = stepped(s.odd);  // the same with x / 4
  uint c2e = s.even.y + 4u * s.even.z + 9u * s.even.w, c2o = s.odd.y + 4u * s.odd.z + 9u * s.odd.w;  // with (x / 4)^2
  uint weight = halves(c0e) + halves(c0o);
  uint x = 4u * (halves(c1e) + halves(c1o)) + 2u * upper(c0e) + lower(c0o) + 3u * upper(c0o);
  uint xx = 16u * (halves(c2e) + halves(c2o)) + 8u * (2u * upper(c1e) + lower(c1o) + 3u * upper(c1o)) + 4u * upper(c0e) + lower(c0o) +
            9u * upper(c0o);
  uint d0e = added(s.y_even), d0o = added(s.y_odd);
  uint y = halves(d0e) + halves(d0o);
  uint xy = 4u * (halves(stepped(s.y_even)) + halves(stepped(s.y_odd))) + 2u * upper(d0e) + lower(d0o) + 3u * upper(d0o);
  uint half_yy = halves(s.yy.x) + halves(s.yy.y) + halves(s.yy.z) + halves(s.yy.w);
  uint grey = halves(added(s.grey));
  uint peak = upper(max(max(s.peak.x, s.peak.y), max(s.peak.z, s.peak.w)));

  uint columns = component.x | component.y | component.z | component.w;
  columns = lower(columns) | upper(columns);
  uvec4 pairs = rows_with_bits(component);
  uint rows = pairs.x | (pairs.y << 2) | (pairs.z << 4) | (pairs.w << 6);
  uint box = uint(findLSB(columns)) | (uint(findMSB(columns)) << 4) | (uint(findLSB(rows)) << 8) | (uint(findMSB(rows)) << 11);
  first = uvec4(count_bits(component) | (peak << 8) | (box << 16), grey | (weight << 16), x, y);
  second = uvec4(xx, xy, 2u * half_yy - y, tile);
}
