// SPDX-License-Identifier: MIT
// Reports to and from bytes, without a C library.
#pragma once

#include <stddef.h>
#include <stdint.h>

namespace glint::board {

inline void copy_bytes(void* to, const void* from, size_t size) { __builtin_memcpy(to, from, size); }

}  // namespace glint::board
