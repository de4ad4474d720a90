// SPDX-License-Identifier: MIT
// 64-bit two's complement integers as uvec2(low, high): exact sums without shaderInt64.

uvec2 wide_add(uvec2 a, uvec2 b) {
  uint carry;
  uint low = uaddCarry(a.x, b.x, carry);
  return uvec2(low, a.y + b.y + carry);
}

uvec2 wide_negate(uvec2 a) { return wide_add(~a, uvec2(1u, 0u)); }

// a * b modulo 2^64: right for signed a and b as long as the product fits.
uvec2 wide_multiply(uvec2 a, int b) {
  uint magnitude = uint(abs(b));
  uint high, low;
  umulExtended(a.x, magnitude, high, low);
  uvec2 product = uvec2(low, high + a.y * magnitude);
  return b < 0 ? wide_negate(product) : product;
}

uvec2 wide_multiply(uint a, int b) {
  uint high, low;
  umulExtended(a, uint(abs(b)), high, low);
  return b < 0 ? wide_negate(uvec2(low, high)) : uvec2(low, high);
}

float wide_to_float(uvec2 a) {
  bool negative = (a.y & 0x80000000u) != 0u;
  uvec2 m = negative ? wide_negate(a) : a;
  float value = float(m.y) * 4294967296.0 + float(m.x);
  return negative ? -value : value;
}
