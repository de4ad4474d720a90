// SPDX-License-Identifier: MIT
// Row by row: find runs, sum them, join them to the runs above, give out blobs that ended.
#include "gpu/cpu/band_labeller.hpp"

#include <algorithm>

namespace glint::gpu {
namespace {

constexpr std::uint32_t kNone = 0xffffffffu;

void add_run(BlobMoments& m, std::uint32_t x_begin, std::uint32_t x_end, const RunSums& s,
             std::uint32_t y) noexcept {
  const std::uint64_t x0 = x_begin, w = s.w, y64 = y;
  const std::uint64_t wx = s.wi + x0 * w;
  m.area += x_end - x_begin;
  m.peak = std::max(m.peak, s.peak);
  m.x_min = std::min(m.x_min, x_begin);
  m.x_max = std::max(m.x_max, x_end - 1);
  m.y_max = y;
  m.sum += s.sum;
  m.w += w;
  m.wx += wx;
  m.wy += y64 * w;
  m.wxx += s.wii + 2 * x0 * s.wi + x0 * x0 * w;
  m.wxy += y64 * wx;
  m.wyy += y64 * y64 * w;
}

}  // namespace

LimitImage::LimitImage(std::uint32_t width_px, std::uint32_t height_px)
    : width_px_(width_px),
      height_px_(height_px),
      lines_per_row_((std::size_t{width_px} + kLimitPadding + sizeof(CacheLine) - 1) / sizeof(CacheLine)),
      coarse_stride_((std::size_t{width_px} + kCoarsePixels - 1) / kCoarsePixels),
      lines_(lines_per_row_ * height_px),
      coarse_(coarse_stride_ * height_px, std::uint8_t{255}) {
  for (CacheLine& line : lines_) std::fill(std::begin(line.bytes), std::end(line.bytes), std::uint8_t{255});
}

void LimitImage::set(std::span<const std::uint8_t> values) {
  for (std::size_t y = 0; y < height_px_; ++y) {
    const auto row = values.subspan(y * width_px_, width_px_);
    for (std::size_t x = 0; x < width_px_; ++x) {
      lines_[y * lines_per_row_ + x / sizeof(CacheLine)].bytes[x % sizeof(CacheLine)] = row[x];
    }
    for (std::size_t c = 0; c < coarse_stride_; ++c) {
      const std::size_t begin = c * kCoarsePixels;
      const auto part = row.subspan(begin, std::min<std::size_t>(kCoarsePixels, width_px_ - begin));
      coarse_[y * coarse_stride_ + c] = *std::min_element(part.begin(), part.end());
    }
  }
}

BandLabeller::BandLabeller(std::uint32_t width_px, std::uint32_t y_begin, std::uint32_t y_end,
                           bool band_above, bool band_below, std::uint32_t first_slot, std::size_t max_kept)
    : width_px_(width_px),
      y_begin_(y_begin),
      y_end_(y_end),
      first_slot_(first_slot),
      band_above_(band_above),
      band_below_(band_below),
      row_(width_px),
      other_row_(width_px),
      first_row_memory_(band_above ? width_px : 0),
      sums_((width_px + 1) / 2),
      finished_(max_kept) {
  free_.reserve(slots(width_px));
  joined_.reserve(slots(width_px));
}

void BandLabeller::clear() noexcept {
  used_slots_ = 0;
  free_.clear();
  joined_.clear();
  above_ = {};
  first_row_ = {};
  last_row_ = {};
  finished_.clear();
}

std::uint32_t BandLabeller::new_component(ComponentTable& table, std::uint32_t y, bool pinned) noexcept {
  std::uint32_t slot;
  if (free_.empty()) {
    slot = first_slot_ + used_slots_++;
  } else {
    slot = free_.back();
    free_.pop_back();
  }
  Component& component = table[slot];
  component = Component{BlobMoments{}, slot, y, true, pinned};
  component.moments.x_min = kNone;
  component.moments.y_min = y;
  return slot;
}

void BandLabeller::connect(std::uint32_t y, ComponentTable& table) noexcept {
  for_touching_runs(above_, current_, [&](std::size_t upper, std::size_t lower) {
    const std::uint32_t found = table.root(above_.component[upper]);
    std::uint32_t& mine = current_.component[lower];
    if (mine == kNone) {
      mine = found;
    } else if (const std::uint32_t own = table.root(mine); own != found) {
      const auto [winner, loser] = table.join(own, found);
      mine = winner;
      if (!table[loser].pinned) joined_.push_back(loser);
    }
  });
  const bool pinned = band_above_ && y == y_begin_;
  for (std::size_t i = 0; i < current_.count; ++i) {
    std::uint32_t& mine = current_.component[i];
    mine = mine == kNone ? new_component(table, y, pinned) : table.root(mine);
    Component& component = table[mine];
    component.last_row = y;
    add_run(component.moments, current_.x_begin(i), current_.x_end(i), sums_[i], y);
  }
}

/// Gives out the blobs of the row above that do not go on in row y, and frees slots.
void BandLabeller::retire(std::uint32_t y, const AreaFilter& filter, ComponentTable& table) noexcept {
  for (std::size_t i = 0; i < above_.count; ++i) {
    const std::uint32_t slot = table.root(above_.component[i]);
    Component& component = table[slot];
    if (component.last_row == y || component.pinned || !component.live) continue;
    filter.offer(component.moments, finished_);
    component.live = false;
    free_.push_back(slot);
  }
  free_.insert(free_.end(), joined_.begin(), joined_.end());
  joined_.clear();
}

void BandLabeller::run(const ImageView& image, const LimitImage& limit, const RowKernels& kernels,
                       const AreaFilter& filter, ComponentTable& table) noexcept {
  clear();
  RowMemory *row = &row_, *other = &other_row_;
  for (std::uint32_t y = y_begin_; y < y_end_; ++y) {
    const std::uint8_t* pixels = image.pixels + std::size_t{y} * image.stride_bytes;
    const std::uint8_t* limits = limit.row(y);
    const std::uint8_t* limits_below = limit.row(std::min(y + 1, y_end_ - 1));
    const std::uint32_t count =
        kernels.scan(pixels, limits, limits_below, limit.coarse_row(y), width_px_, row->edges.data());
    if (count == 0 && above_.count == 0) continue;
    current_ = {row->edges.data(), row->component.data(), count};
    std::fill_n(row->component.data(), count, kNone);
    kernels.measure(pixels, limits, width_px_, row->edges.data(), count, sums_.data());
    connect(y, table);
    if (band_above_ && y == y_begin_) {
      std::copy_n(row->edges.data(), 2 * count, first_row_memory_.edges.data());
      std::copy_n(row->component.data(), count, first_row_memory_.component.data());
      first_row_ = {first_row_memory_.edges.data(), first_row_memory_.component.data(), count};
    }
    retire(y, filter, table);
    above_ = current_;
    std::swap(row, other);
  }
  if (band_below_) {
    last_row_ = above_;
  } else {
    retire(y_end_, filter, table);
  }
}

}  // namespace glint::gpu
