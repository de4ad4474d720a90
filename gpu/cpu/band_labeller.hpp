// SPDX-License-Identifier: MIT
// Blobs of a band of rows, from top to bottom, in memory that does not grow with the picture.
#pragma once

#include <cstdint>
#include <vector>

#include "gpu/cpu/component_table.hpp"
#include "gpu/cpu/keep_first.hpp"
#include "gpu/cpu/row_kernels.hpp"

namespace glint::gpu {

struct AreaFilter {
  std::uint32_t min_px, max_px;
  void offer(const BlobMoments& blob, KeepFirst& kept) const noexcept {
    if (blob.area >= min_px && blob.area <= max_px) kept.offer(blob);
  }
};

/// The runs of one row and the slots of the blobs that they belong to.
struct BorderRow {
  std::vector<PixelRun> runs;
  std::vector<std::uint32_t> slots;
};

/// Rows y_begin <= y < y_end of one camera, and what was found in them.
struct Band {
  /// Slots that a band of this width needs in the camera's table.
  static std::uint32_t slots_needed(std::uint32_t width_px) noexcept { return 2 * ((width_px + 1) / 2); }

  Band(std::uint32_t width_px, std::uint32_t first_row, std::uint32_t end_row, bool has_above, bool has_below,
       std::uint32_t first_table_slot, std::size_t max_kept);
  /// Nothing was found.
  void clear() noexcept;

  std::uint32_t y_begin, y_end;
  bool band_above, band_below;
  std::uint32_t first_slot;  ///< of this band's slots in the camera's table
  KeepFirst finished;        ///< blobs that no other band can join
  BorderRow first, last;     ///< the first row if a band is above, the last row if one is below
};

/// A thread's desk for labelling bands, one after the other.
class BandLabeller {
 public:
  /// For bands of at most this width.
  explicit BandLabeller(std::uint32_t max_width_px);

  /// Blobs that may go on in other bands are left in `open`, which is the camera's table; each band has its
  /// own slots there.
  void run(const Rows& rows, const RowKernels& kernels, const AreaFilter& filter, Band& band,
           ComponentTable& open) noexcept;

 private:
  std::uint32_t new_slot() noexcept;
  void link(std::uint32_t begin, std::uint32_t end, std::uint32_t stride) noexcept;
  void retire(std::uint32_t y_reached, bool top_is_open, const AreaFilter& filter, Band& band) noexcept;
  void hand_over(Band& band, ComponentTable& open) noexcept;

  std::vector<PixelRun> runs_;  // those of the row above, then new ones
  std::vector<BlobMoments> moments_;
  std::vector<std::uint32_t> slots_;  // of the runs
  ComponentTable table_;
  std::vector<std::uint32_t> live_, free_;  // slots
  std::uint32_t used_slots_ = 0;            // slots from here on were never taken in this band
};

}  // namespace glint::gpu
