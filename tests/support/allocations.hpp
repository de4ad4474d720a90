// SPDX-License-Identifier: MIT
// Counts calls of operator new in a test program that is linked with allocations.cpp.
#pragma once

#include <cstddef>

namespace glint::testing {

/// Calls of any operator new since the program started, in all threads.
std::size_t allocations() noexcept;

/// Bytes that malloc has lent out, in all threads and libraries.
std::size_t heap_bytes() noexcept;

}  // namespace glint::testing
