// SPDX-License-Identifier: MIT
// What is kept of a component of a tile, by its number within the camera. The component of tile number i of the camera's list
// has number i; where a tile has several, they have numbers from `tiles of the camera` on, and i is left out.
//
// links[link_base + tile], tile = x + y * tiles_x, and links[link_base + number] for those of divided tiles:
//   top row | bottom row << 16, of a divided tile those of all its components
//   left column | right column << 8 | kDivided if the tile has several components
//   the component's number; in a divided tile the number of its first one, and there that of the next one (0: none)
//   stamp of the frame set: a tile with another stamp is dark
// sums[2 (component_base + number)]:
//   area | peak << 8 | x_min << 16 | x_max << 20 | y_min << 24 | y_max << 27
//   grey sum | weight << 16
//   x, y
// sums[2 (component_base + number) + 1]:
//   xx, xy, yy
//   tile (x | y << 16)
// where x is sum w x and so on, about the first pixel of the tile. Texel buffers and not storage buffers: Mesa's CPU driver
// moves the 16 bytes of a texel at once, but what is in a storage buffer word by word.

const uint kDivided = 0x10000u;

uvec4 make_link(uvec4 component, uint number, uint stamp) {
  return uvec4(top_row(component) | (bottom_row(component) << 16),
               tile_column(component, 0u) | (tile_column(component, kTileWidth - 1u) << 8), number, stamp);
}

bool is_divided(uvec4 link) { return (link.y & kDivided) != 0u; }

uint link_top(uvec4 link) { return link.x & 0xffffu; }
uint link_bottom(uvec4 link) { return link.x >> 16; }
uint link_left(uvec4 link) { return link.y & 0xffu; }
uint link_right(uvec4 link) { return (link.y >> 8) & 0xffu; }

// Neighbours that come before a tile in reading order.
const uint kAboveLeft = 0u;
const uint kAbove = 1u;
const uint kAboveRight = 2u;
const uint kLeft = 3u;

uint spread(uint border) { return border | (border << 1) | (border >> 1); }

// Whether a component touches one of the tile in that direction.
bool touches_left(uvec4 link, uvec4 left) { return (spread(link_left(link)) & link_right(left)) != 0u; }
bool touches_above(uvec4 link, uvec4 above) { return (spread(link_top(link)) & link_bottom(above)) != 0u; }
bool touches_above_left(uvec4 link, uvec4 other) { return (link_top(link) & (link_bottom(other) >> 15)) != 0u; }
bool touches_above_right(uvec4 link, uvec4 other) { return ((link_top(link) >> 15) & link_bottom(other)) != 0u; }
