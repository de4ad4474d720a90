// SPDX-License-Identifier: MIT
// Step 5: every component that is not a root enters the list of its root; the roots are listed.

// Place i: first the components of undivided tiles, then those of divided ones.
void enter_list(uint camera, uint i, uint tiles) {
  uint base = cameras[camera].component_base;
  uint number = i < tiles ? i : cameras[camera].tiles_x * cameras[camera].tiles_y + i - tiles;
  uint parent = parents[base + number];
  bool lit = parent != kNoComponent;
  uint root = lit ? find_root(number, camera) : number;
  if (lit && root != number) chain[base + number] = atomicExchange(heads[base + root], number + 1u);
  if (lit && root == number) {
    uint place = atomicAdd(counters[camera].roots, 1u);
    roots[base + place] = number;
#if GLINT_STEP == 5
    atomicMax(sizes.roots.x, place / kSplitGroup + 1u);
#endif
  }
}
