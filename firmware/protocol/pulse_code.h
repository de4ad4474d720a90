// SPDX-License-Identifier: MIT
// In which frames of a run the sync board leaves its lights dark; the same as host/base/pulse_code.hpp.
#pragma once

#include <stdint.h>

#define GLINT_PULSE_CODE_GROUPS 256
#define GLINT_PULSE_CODE_LEAST_GROUP 18
#define GLINT_PULSE_CODE_MOST_GROUP 1024

// Frames, counted from 0, come in groups of `group`; frame k is dark if k % group is what this says for
// group_no = k / group. (The mixing is the finalizer of MurmurHash3, Appleby 2011.)
static inline uint32_t glint_pulse_code_dark(uint32_t seed, uint32_t group, uint32_t group_no) {
  uint32_t x = seed + 0x9e3779b9u * (group_no % GLINT_PULSE_CODE_GROUPS + 1u);
  x = (x ^ x >> 16) * 0x85ebca6bu;
  x = (x ^ x >> 13) * 0xc2b2ae35u;
  x = x ^ x >> 16;
  uint64_t scaled = x;
  scaled = scaled * (group / 2u) >> 32;
  return scaled & 0xffffffffu;
}
