// SPDX-License-Identifier: MIT
// Step 3: a tile's component gets one that it touches, earlier in reading order, as its parent. Where it touches several
// that nothing else joins, or where a tile has several components, the pair of tiles is listed for step 4.

void join_tile(uint camera, uint i) {
  uint tile_base = cameras[camera].tile_base, base = cameras[camera].component_base;
  uint entry = tile_list[tile_base + i];
  uint x = entry & 0xffffu, y = entry >> 16;
  uint tiles_x = cameras[camera].tiles_x, stamp = cameras[camera].stamp;
  uint tile = x + y * tiles_x;
  uint at = base + tile;
  // Outside of the image another tile is loaded instead, and not used.
  uint above = at - (y > 0u ? tiles_x : 0u), to_left = x > 0u ? 1u : 0u, to_right = x + 1u < tiles_x ? 1u : 0u;
  uvec4 self = imageLoad(links, int(at));
  uvec4 l = imageLoad(links, int(at - to_left));
  uvec4 a = imageLoad(links, int(above));
  uvec4 al = imageLoad(links, int(above - to_left));
  uvec4 ar = imageLoad(links, int(above + to_right));
  bool lit = self.w == stamp;
  bool has_l = lit && x > 0u && l.w == stamp;
  bool has_a = lit && y > 0u && a.w == stamp;
  bool has_al = lit && x > 0u && y > 0u && al.w == stamp;
  bool has_ar = lit && y > 0u && to_right != 0u && ar.w == stamp;

  bool divided_self = is_divided(self);
  bool l_touches = has_l && touches_left(self, l);
  bool a_touches = has_a && touches_above(self, a);
  bool al_touches = has_al && touches_above_left(self, al);
  bool ar_touches = has_ar && touches_above_right(self, ar);
  bool l_divided = l_touches && (divided_self || is_divided(l));
  bool a_divided = a_touches && (divided_self || is_divided(a));
  bool al_divided = al_touches && (divided_self || is_divided(al));
  bool ar_divided = ar_touches && (divided_self || is_divided(ar));
  bool l_joins = l_touches && !l_divided;
  bool a_joins = a_touches && !a_divided;
  bool al_joins = al_touches && !al_divided;
  bool ar_joins = ar_touches && !ar_divided;
  uint parent = al_joins ? al.z : a_joins ? a.z : ar_joins ? ar.z : l_joins ? l.z : i;
  parents[base + i] = lit && !divided_self ? parent : kNoComponent;

  // A neighbour that touches one that is joined already was joined to that one when its own turn came.
  bool a_known = !al_joins || touches_left(a, al);
  bool ar_known = !(al_joins || a_joins) || (a_joins && touches_left(ar, a));
  bool l_known = !(al_joins || a_joins || ar_joins) || (al_joins && touches_above(l, al)) ||
                 (a_joins && touches_above_right(l, a));
  uint listed = (al_divided ? 1u << kAboveLeft : 0u) | (a_divided || (a_joins && !a_known) ? 1u << kAbove : 0u) |
                (ar_divided || (ar_joins && !ar_known) ? 1u << kAboveRight : 0u) |
                (l_divided || (l_joins && !l_known) ? 1u << kLeft : 0u);
  while (listed != 0u) {
    uint direction = uint(findLSB(listed));
    listed &= listed - 1u;
    uint place = atomicAdd(counters[camera].pairs, 1u);
    pairs[4u * tile_base + place] = tile | (direction << 30);
#if GLINT_STEP == 3
    atomicMax(sizes.pairs.x, place / kSplitGroup + 1u);
#endif
  }
}
