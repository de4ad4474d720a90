// SPDX-License-Identifier: MIT
// Markers found and stuffed bytes taken out, in stretches between bytes of 0xff.
#include <new>

#include "host/capture/jpeg/entropy_bits.hpp"

namespace glint {
namespace {

constexpr std::uint8_t kFirstRestart = 0xd0, kEndOfImage = 0xd9;

}  // namespace

void EntropyData::reserve(std::size_t bytes) {
  const std::size_t room = bytes + kMostParts * kBehind;
  if (bytes_.size() < room) bytes_.resize(room);
  ends_.reserve(kMostParts);
}

bool EntropyData::read(std::span<const std::uint8_t> data) noexcept {
  ends_.clear();
  try {
    reserve(data.size());
  } catch (const std::bad_alloc&) {
    return false;
  }
  const std::uint8_t* from = data.data();
  const std::uint8_t* const end = from + data.size();
  std::size_t used = 0;
  for (;;) {
    const auto* marker = static_cast<const std::uint8_t*>(
        from == end ? nullptr : std::memchr(from, 0xff, static_cast<std::size_t>(end - from)));
    if (marker == nullptr || marker + 1 == end) return false;
    const std::uint8_t kind = marker[1];
    const auto length = static_cast<std::size_t>(marker - from) + (kind == 0 ? 1 : 0);
    std::memcpy(bytes_.data() + used, from, length);
    used += length;
    from = marker + 2;
    if (kind == 0) continue;
    const bool restart = kind == kFirstRestart + ends_.size() % 8;
    if (!restart && kind != kEndOfImage) return false;
    if (ends_.size() == kMostParts) return false;
    ends_.push_back(used);
    std::memset(bytes_.data() + used, 0, kBehind);
    used += kBehind;
    if (kind == kEndOfImage) return true;
  }
}

}  // namespace glint
