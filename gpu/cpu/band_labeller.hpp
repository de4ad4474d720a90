// SPDX-License-Identifier: MIT
// Blobs of a band of rows, in one pass from top to bottom and in memory for two rows.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "gpu/cpu/component_table.hpp"
#include "gpu/cpu/keep_first.hpp"
#include "gpu/cpu/row_kernels.hpp"

namespace glint::gpu {

/// The limit image of a camera, laid out for the row kernels.
class LimitImage {
 public:
  /// 255 everywhere: nothing is bright.
  LimitImage(std::uint32_t width_px, std::uint32_t height_px);
  /// values: width_px * height_px bytes.
  void set(std::span<const std::uint8_t> values);

  const std::uint8_t* row(std::uint32_t y) const noexcept { return lines_[y * lines_per_row_].bytes; }
  const std::uint8_t* coarse_row(std::uint32_t y) const noexcept {
    return coarse_.data() + y * coarse_stride_;
  }

 private:
  struct alignas(64) CacheLine {
    std::uint8_t bytes[64];
  };
  std::uint32_t width_px_, height_px_;
  std::size_t lines_per_row_, coarse_stride_;
  std::vector<CacheLine> lines_;
  std::vector<std::uint8_t> coarse_;
};

struct AreaFilter {
  std::uint32_t min_px, max_px;
  void offer(const BlobMoments& blob, KeepFirst& kept) const noexcept {
    if (blob.area >= min_px && blob.area <= max_px) kept.offer(blob);
  }
};

/// Rows y_begin <= y < y_end of one camera. Blobs that no other band can join are finished here; those
/// at its first row (if a band is above) and last row (if one is below) stay in the table.
class BandLabeller {
 public:
  /// Slots needed in the table by a band of this width: blobs of the first row, of the row above, and of
  /// the current row.
  static std::uint32_t slots(std::uint32_t width_px) noexcept { return 3 * ((width_px + 1) / 2) + 1; }

  BandLabeller(std::uint32_t width_px, std::uint32_t y_begin, std::uint32_t y_end, bool band_above,
               bool band_below, std::uint32_t first_slot, std::size_t max_kept);

  void run(const ImageView& image, const LimitImage& limit, const RowKernels& kernels,
           const AreaFilter& filter, ComponentTable& table) noexcept;
  /// As run() on a band without light.
  void clear() noexcept;

  const RowRuns& first_row() const noexcept { return first_row_; }
  const RowRuns& last_row() const noexcept { return last_row_; }
  const KeepFirst& finished() const noexcept { return finished_; }

 private:
  std::uint32_t new_component(ComponentTable& table, std::uint32_t y, bool pinned) noexcept;
  void connect(std::uint32_t y, ComponentTable& table) noexcept;
  void retire(std::uint32_t y, const AreaFilter& filter, ComponentTable& table) noexcept;

  std::uint32_t width_px_, y_begin_, y_end_, first_slot_;
  bool band_above_, band_below_;
  std::uint32_t used_slots_ = 0;              // slots from here on were never taken in this frame
  std::vector<std::uint32_t> free_, joined_;  // joined_: free once no run of this row refers to them
  struct RowMemory {
    std::vector<std::uint32_t> edges, component;
    explicit RowMemory(std::uint32_t width_px)
        : edges(edges_needed(width_px)), component((width_px + 1) / 2) {}
  };
  RowMemory row_, other_row_, first_row_memory_;
  std::vector<RunSums> sums_;
  RowRuns above_, current_, first_row_, last_row_;
  KeepFirst finished_;
};

}  // namespace glint::gpu
