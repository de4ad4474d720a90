// SPDX-License-Identifier: MIT
// Tells builds with different shaders apart.
#pragma once

#include <cstdint>

namespace glint::gpu {

/// 64-bit FNV-1a (Fowler, Noll, Vo) over the SPIR-V words of all embedded shaders, in the order in which
/// shaders/CMakeLists.txt names them; each word counts as its four bytes, lowest first.
std::uint64_t shader_hash() noexcept;

}  // namespace glint::gpu
