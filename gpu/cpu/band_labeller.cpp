// SPDX-License-Identifier: MIT
// Finds many runs, sums them, joins them to the runs above, gives out blobs that ended; and so on downwards.
#include "gpu/cpu/band_labeller.hpp"

#include <algorithm>

namespace glint::gpu {
namespace {

constexpr std::uint32_t kNone = 0xffffffffu;

}  // namespace

Band::Band(std::uint32_t width_px, std::uint32_t first_row, std::uint32_t end_row, bool has_above,
           bool has_below, std::uint32_t first_table_slot, std::size_t max_kept)
    : y_begin(first_row),
      y_end(end_row),
      band_above(has_above),
      band_below(has_below),
      first_slot(first_table_slot),
      finished(max_kept) {
  const std::size_t most = (width_px + 1) / 2;
  for (BorderRow* row : {&first, &last}) {
    row->runs.reserve(most);
    row->slots.reserve(most);
  }
}

void Band::clear() noexcept {
  finished.clear();
  for (BorderRow* row : {&first, &last}) {
    row->runs.clear();
    row->slots.clear();
  }
}

BandLabeller::BandLabeller(std::uint32_t max_width_px)
    : runs_(most_runs_found(max_width_px) + (max_width_px + 1) / 2 + 2),
      moments_(runs_.size()),
      slots_(runs_.size()),
      // New ones, those of the row above, and those of the first row.
      table_(most_runs_found(max_width_px) + 2 * ((max_width_px + 1) / 2)) {
  live_.reserve(table_.slots());
  free_.reserve(table_.slots());
}

std::uint32_t BandLabeller::new_slot() noexcept {
  if (free_.empty()) return used_slots_++;
  const std::uint32_t slot = free_.back();
  free_.pop_back();
  return slot;
}

/// Joins the runs begin <= r < end to those above them, and adds them up.
void BandLabeller::link(std::uint32_t begin, std::uint32_t end, std::uint32_t stride) noexcept {
  const PixelRun* const runs = runs_.data();
  const BlobMoments* const moments = moments_.data();
  std::uint32_t* const slots = slots_.data();
  // `above`: the first run that may touch run r, which it does when it would overlap or adjoin it one row
  // further down. It needs no check against running past r, which does not touch itself.
  const PixelRun* above = runs;
  for (std::uint32_t r = begin; r < end; ++r) {
    const PixelRun run = runs[r];
    while (above->end + stride < run.begin) ++above;
    if (above->begin + stride > run.end) {
      const std::uint32_t slot = new_slot();
      slots[r] = slot;
      table_[slot] = {moments[r], slot, kNone};
      live_.push_back(slot);
      continue;
    }
    std::uint32_t slot = table_.root(slots[above - runs]);
    for (; above[1].begin + stride <= run.end; ++above) {
      const std::uint32_t other = table_.root(slots[above + 1 - runs]);
      if (other != slot) slot = table_.join(slot, other);
    }
    slots[r] = slot;
    BlobMoments& sums = table_[slot].moments;
    sums.append(moments[r]);
    sums.y_max = moments[r].y_max;
  }
}

/// Gives out the blobs that end above row y_reached, and frees all slots that no run below refers to.
void BandLabeller::retire(std::uint32_t y_reached, bool top_is_open, const AreaFilter& filter,
                          Band& band) noexcept {
  std::size_t kept = 0;
  for (const std::uint32_t slot : live_) {
    const Component& component = table_[slot];
    const bool root = component.parent == slot;
    if (top_is_open && component.moments.y_min == band.y_begin) {
      if (root) live_[kept++] = slot;
      continue;  // the first row refers to it
    }
    if (root && component.moments.y_max >= y_reached) {
      live_[kept++] = slot;
      continue;
    }
    if (root) filter.offer(component.moments, band.finished);
    free_.push_back(slot);
  }
  live_.resize(kept);
}

/// Moves the blobs of the first and last row to the camera's table.
void BandLabeller::hand_over(Band& band, ComponentTable& open) noexcept {
  std::uint32_t next = band.first_slot;
  for (BorderRow* row : {&band.first, &band.last}) {
    for (std::uint32_t& slot : row->slots) {
      Component& component = table_[table_.root(slot)];
      if (component.note == kNone) {
        component.note = next;
        open[next] = {component.moments, next, kNone};
        ++next;
      }
      slot = component.note;
    }
  }
}

void BandLabeller::run(const Rows& rows, const RowKernels& kernels, const AreaFilter& filter, Band& band,
                       ComponentTable& open) noexcept {
  band.clear();
  live_.clear();
  free_.clear();
  used_slots_ = 0;
  const std::uint32_t stride = position_stride(rows.width);
  std::uint32_t carried = 0;  // runs of the row above
  for (std::uint32_t y = band.y_begin; y < band.y_end;) {
    const auto [next, found] = kernels.find(rows, y, band.y_end, runs_.data() + carried);
    const std::uint32_t end = carried + found;
    kernels.measure(rows, runs_.data() + carried, found, moments_.data() + carried);
    link(carried, end, stride);
    if (band.band_above && y == band.y_begin) {
      std::uint32_t count = 0;
      while (count < end && runs_[count].begin < (y + 1) * stride) ++count;
      band.first.runs.assign(runs_.begin(), runs_.begin() + count);
      band.first.slots.assign(slots_.begin(), slots_.begin() + count);
    }
    std::uint32_t last = end;
    while (last > 0 && runs_[last - 1].begin >= (next - 1) * stride) --last;
    carried = end - last;
    for (std::uint32_t r = 0; r < carried; ++r) {
      runs_[r] = runs_[last + r];
      slots_[r] = table_.root(slots_[last + r]);
    }
    y = next;
    if (y == band.y_end && band.band_below) {
      band.last.runs.assign(runs_.begin(), runs_.begin() + carried);
      band.last.slots.assign(slots_.begin(), slots_.begin() + carried);
    }
    retire(y == band.y_end && !band.band_below ? kNone : y - 1, band.band_above, filter, band);
  }
  hand_over(band, open);
}

}  // namespace glint::gpu
