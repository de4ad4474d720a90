// SPDX-License-Identifier: MIT
// Lock-free union-find over the components of a camera; a root is its own parent. Unions make the root with the smaller
// number the parent.

// Halves the path on the way. A plain store will do: it may undo somebody's link of `number`, who then sees that `number` was
// no root and joins its old parent instead.
uint find_root(uint number, uint camera) {
  uint base = cameras[camera].component_base;
  uint parent = parents[base + number];
  bool more = parent != number;
  while (more) {
    uint grandparent = parents[base + parent];
    if (grandparent != parent) parents_out[base + number] = grandparent;
    number = parent;
    parent = grandparent;
    more = parent != number && spend_turn();
  }
  if (!has_turns()) atomicOr(counters[camera].flags, kCounterChainTooLong);
  return number;
}

#if GLINT_STEP == 0 || GLINT_STEP == 4
void unite(uint a, uint b, uint camera) {
  uint base = cameras[camera].component_base;
  bool more;
  do {
    a = find_root(a, camera);
    b = find_root(b, camera);
    uint low = min(a, b), high = max(a, b);
    more = low != high;
    if (more) {
      // If `high` was no root any more, what it was joined to meanwhile has to be joined too.
      uint before = atomicMin(parents[base + high], low);
      more = before != high && spend_turn();
      a = low;
      b = before;
    }
  } while (more);
}
#endif
