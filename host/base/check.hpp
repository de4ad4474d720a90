// SPDX-License-Identifier: MIT
// A broken assumption of our own: say where and stop, in release builds too.
#pragma once

#include <cstdio>
#include <cstdlib>

#define GLINT_CHECK(condition)                                                           \
  do {                                                                                   \
    if (!(condition)) [[unlikely]] {                                                     \
      std::fprintf(stderr, "glint: bug: %s at %s:%d\n", #condition, __FILE__, __LINE__); \
      std::abort();                                                                      \
    }                                                                                    \
  } while (false)
