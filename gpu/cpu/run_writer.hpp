// SPDX-License-Identifier: MIT
// What the kernels of all instruction sets share.
#pragma once

#include <algorithm>
#include <bit>
#include <cstdint>

#include "gpu/cpu/row_kernels.hpp"

namespace glint::gpu {

/// Turns bright pixels, 64 after 64, into runs.
class RunWriter {
 public:
  explicit RunWriter(PixelRun* runs) noexcept : edges_(reinterpret_cast<std::uint32_t*>(runs)) {}

  /// The pixels at position .. position + 63, lowest bit first; those left out before them are dark.
  [[gnu::always_inline]] void add(std::uint64_t bits, std::uint32_t position) noexcept {
    if ((lit_ & static_cast<std::uint64_t>(position != end_)) != 0) [[unlikely]] {
      edges_[count_++] = end_;
      lit_ = 0;
    }
    std::uint64_t changes = bits ^ ((bits << 1) | lit_);
    lit_ = bits >> 63;
    end_ = position + 64;
    // Most groups have two edges at most: writing two and keeping as many as there are takes no branch that
    // could be guessed wrong.
    const auto count = static_cast<std::uint32_t>(std::popcount(changes));
    edges_[count_] = position + static_cast<std::uint32_t>(std::countr_zero(changes));
    changes &= changes - 1;
    edges_[count_ + 1] = position + static_cast<std::uint32_t>(std::countr_zero(changes));
    if (count > 2) [[unlikely]] {
      std::uint32_t at = count_ + 2;
      for (changes &= changes - 1; changes != 0; changes &= changes - 1) {
        edges_[at++] = position + static_cast<std::uint32_t>(std::countr_zero(changes));
      }
    }
    count_ += count;
  }
  /// Nothing follows; returns how many runs were written.
  [[gnu::always_inline]] std::uint32_t finish() noexcept {
    if (lit_ != 0) edges_[count_++] = end_;
    lit_ = 0;
    return count_ / 2;
  }

 private:
  std::uint32_t* edges_;
  std::uint32_t count_ = 0, end_ = 0;  // end_: behind the pixels added last
  std::uint64_t lit_ = 0;              // 1: the last pixel so far was bright
};

/// Sums over the pixels of a run; w = value - limit, i = x - first x.
struct RunSums {
  std::uint64_t wi, wii;
  std::uint32_t sum, w, peak;
};

/// Adds a piece that starts at pixel `offset` of its run.
[[gnu::always_inline]] inline void add_piece(RunSums& s, std::uint64_t offset,
                                             const RunSums& piece) noexcept {
  s.sum += piece.sum;
  s.w += piece.w;
  s.wi += piece.wi + offset * piece.w;
  s.wii += piece.wii + 2 * offset * piece.wi + offset * offset * piece.w;
  s.peak = std::max(s.peak, piece.peak);
}

[[gnu::always_inline]] inline BlobMoments run_moments(std::uint32_t x_begin, std::uint32_t y,
                                                      std::uint32_t length, const RunSums& s) noexcept {
  const std::uint64_t x = x_begin, y64 = y, w = s.w;
  const std::uint64_t wx = s.wi + x * w, wy = y64 * w;
  BlobMoments m;
  m.sum = s.sum;
  m.w = w;
  m.wx = wx;
  m.wy = wy;
  m.wxx = s.wii + x * (s.wi + wx);
  m.wxy = y64 * wx;
  m.wyy = y64 * wy;
  m.area = length;
  m.peak = s.peak;
  m.x_min = x_begin;
  m.x_max = x_begin + length - 1;
  m.y_min = m.y_max = y;
  return m;
}

/// 64 pixels of a row, the last `missing` of which lie behind its end.
struct Group {
  const std::uint8_t* pixels;
  std::uint32_t position, missing;
};

/// Groups in a row, at most.
inline constexpr std::uint32_t kMostGroups = 65536 / 64;
/// What list() may write behind the groups that it counts.
inline constexpr std::uint32_t kGroupSlack = 4;

/// Writes those of the 64 whole groups from `pixels` on that `lit` has, at least one, and starts to fetch
/// their limits: groups are looked at only when several rows have been listed.
[[gnu::always_inline]] inline std::uint32_t list_groups(std::uint64_t lit, const std::uint8_t* pixels,
                                                        const std::uint8_t* limit, std::uint32_t position,
                                                        Group* groups) noexcept {
  const auto list_first = [&](Group& group) {
    const auto offset = 64 * static_cast<std::uint32_t>(std::countr_zero(lit));
    group = {pixels + offset, position + offset, 0};
    __builtin_prefetch(limit + position + offset);
  };
  const auto count = static_cast<std::uint32_t>(std::popcount(lit));
  // Most rows have so few that listing a few, some of them twice, is faster than guessing how many.
  for (std::uint32_t i = 0; i < kGroupSlack; ++i) {
    list_first(groups[i]);
    const std::uint64_t rest = lit & (lit - 1);
    lit = rest != 0 ? rest : lit;
  }
  for (std::uint32_t i = kGroupSlack; i < count; ++i, lit &= lit - 1) list_first(groups[i]);
  return count;
}

/// The loops of FindRuns. skip(y) is the first row from y on that may have a bright pixel; list(y, groups)
/// writes the groups of row y that may have one, and returns how many; bits(group) says which pixels are
/// bright. The groups of several rows are listed before any is looked at: the loop over them ends seldom, and
/// it is the ends of loops that the CPU guesses wrong.
template <typename Skip, typename List, typename Bits>
[[gnu::always_inline]] inline FoundRuns find_runs(std::uint32_t width, std::uint32_t y, std::uint32_t y_end,
                                                  PixelRun* runs, Skip skip, List list, Bits bits) noexcept {
  Group groups[kGroupsAtOnce + kMostGroups + kGroupSlack];
  RunWriter writer(runs);
  y = skip(y);
  const std::uint32_t y_last = std::min(y_end, y + 1 + kPixelsAtOnce / width);
  std::uint32_t count = 0;
  for (; y < y_last && count < kGroupsAtOnce; ++y) count += list(y, groups + count);
  for (std::uint32_t i = 0; i < count; ++i) writer.add(bits(groups[i]), groups[i].position);
  return {y, writer.finish()};
}

}  // namespace glint::gpu
