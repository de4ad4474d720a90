// SPDX-License-Identifier: MIT
// Lock-free union-find over slots: a parent's number is never larger than its child's, the root is its own parent.

// A CPU driver ends an invocation's loops silently after 65 535 turns: stop well before and say so.
const uint kLongestChain = 16384u;

#if GLINT_STEP == 0 || GLINT_STEP == 2
// Halves the path on the way. A plain store will do: it may undo somebody's link of `slot`, who then sees that `slot` was
// no root and joins its old parent instead.
uint find_root(uint slot, uint camera) {
  uint turns = 0u;
  uint parent = parents[slot];
  while (parent != slot && turns < kLongestChain) {
    uint grandparent = parents[parent];
    if (grandparent != parent) parents_out[slot] = grandparent;
    slot = parent;
    parent = grandparent;
    turns++;
  }
  if (turns >= kLongestChain) atomicOr(counters[camera].flags, kCounterChainTooLong);
  return slot;
}

void unite(uint a, uint b, uint camera) {
  uint turns = 0u;
  bool done;
  do {
    a = find_root(a, camera);
    b = find_root(b, camera);
    uint low = min(a, b), high = max(a, b);
    done = low == high;
    if (!done) {
      // If `high` was no root any more, what it was joined to meanwhile has to be joined too.
      uint before = atomicMin(parents[high], low);
      done = before == high;
      a = low;
      b = before;
    }
    turns++;
  } while (!done && turns < kLongestChain);
  if (!done) atomicOr(counters[camera].flags, kCounterChainTooLong);
}
#else
uint find_root(uint slot, uint camera) {
  uint turns = 0u;
  uint parent = parents[slot];
  while (parent != slot && turns < kLongestChain) {
    slot = parent;
    parent = parents[slot];
    turns++;
  }
  if (turns >= kLongestChain) atomicOr(counters[camera].flags, kCounterChainTooLong);
  return slot;
}
#endif
