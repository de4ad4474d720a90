// SPDX-License-Identifier: MIT
// What the compiler calls by itself and no C library is there to give.
#include <stddef.h>
#include <stdint.h>

extern "C" {

__attribute__((optimize("no-tree-loop-distribute-patterns"))) void* memcpy(void* to, const void* from,
                                                                           size_t size) {
  auto* target = static_cast<uint8_t*>(to);
  const auto* source = static_cast<const uint8_t*>(from);
  if (((reinterpret_cast<uintptr_t>(to) | reinterpret_cast<uintptr_t>(from)) & 3) == 0) {
    auto* words = static_cast<uint32_t*>(to);
    const auto* source_words = static_cast<const uint32_t*>(from);
    for (; size >= 4; size -= 4) *words++ = *source_words++;
    target = reinterpret_cast<uint8_t*>(words);
    source = reinterpret_cast<const uint8_t*>(source_words);
  }
  while (size-- != 0) *target++ = *source++;
  return to;
}

__attribute__((optimize("no-tree-loop-distribute-patterns"))) void* memset(void* to, int value, size_t size) {
  auto* target = static_cast<uint8_t*>(to);
  while (size-- != 0) *target++ = static_cast<uint8_t>(value);
  return to;
}

void __cxa_pure_virtual() {
  for (;;) {
  }
}
}
