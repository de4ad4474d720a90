// SPDX-License-Identifier: MIT
// The integer sums of a component, one array per field over all slots. Moments are about the first pixel
// of the component's tile; the second half of the fields are 64 bits wide in the roots.
const uint kArea = 0u;
const uint kGreySum = 1u;
const uint kWeight = 2u;
const uint kPeak = 3u;
const uint kXMin = 4u;
const uint kYMin = 5u;
const uint kXMax = 6u;
const uint kYMax = 7u;
const uint kX = 8u;  // low words of sum w x, w y, w x x, w x y, w y y ...
const uint kY = 9u;
const uint kXX = 10u;
const uint kXY = 11u;
const uint kYY = 12u;
const uint kHigh = 5u;  // ... and their high words, this many fields further on
const uint kSumFields = 18u;

uint sum_index(uint field, uint slot) { return field * slots + slot; }

// Tiles are kept as tile_x | tile_y << 16.
ivec2 tile_origin(uint tile) { return ivec2(int((tile & 0xffffu) * kTileWidth), int((tile >> 16) * kTileHeight)); }
