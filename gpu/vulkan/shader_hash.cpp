// SPDX-License-Identifier: MIT
// A hash of what runs on the GPU.
#include "gpu/vulkan/shader_hash.hpp"

#include "shaders/all_shaders.spv.h"

namespace glint::gpu {

std::uint64_t shader_hash() noexcept {
  std::uint64_t hash = 0xcbf29ce484222325u;
  for (const auto& [words, count] : kAllShaders) {
    for (std::size_t i = 0; i < count; ++i) {
      for (unsigned shift = 0; shift < 32; shift += 8) {
        hash ^= words[i] >> shift & 0xffu;
        hash *= 0x100000001b3u;
      }
    }
  }
  return hash;
}

}  // namespace glint::gpu
