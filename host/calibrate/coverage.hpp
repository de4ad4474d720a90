// SPDX-License-Identifier: MIT
// Where a camera has seen the target, and which cameras have seen it together. Cheap enough for live use.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include <Eigen/Core>

#include "host/calibrate/samples.hpp"

namespace glint {

/// Counts of sightings in 8 x 5 cells of one camera's image. Cells are about square for the usual 16:10
/// sensors, and small enough that the edge of the image, where the lens distorts most, has cells of its own.
class CoverageGrid {
 public:
  static constexpr std::size_t kColumns = 8, kRows = 5, kCells = kColumns * kRows;

  CoverageGrid() = default;
  CoverageGrid(std::uint32_t width_px, std::uint32_t height_px) noexcept
      : width_px_(width_px), height_px_(height_px) {}

  /// A pixel outside the image counts for the cell nearest to it; one that is no number is ignored.
  void add(const Eigen::Vector2d& pixel) noexcept;

  std::uint64_t samples() const noexcept { return samples_; }
  /// Row 0 is the top of the image.
  std::uint64_t count(std::size_t column, std::size_t row) const noexcept {
    return counts_[row * kColumns + column];
  }
  /// Share of the cells that hold at least `wanted_per_cell`; 0..1.
  double share(std::uint64_t wanted_per_cell = 1) const noexcept;
  /// How far the cells are filled, each counted up to `wanted_per_cell`; 0..1. Grows with every sample that
  /// helps.
  double fill(std::uint64_t wanted_per_cell) const noexcept;
  /// "nothing yet in the lower left of the image" (no cell of that ninth of the image has a sample), else
  /// "too little yet in the top of the image" (less than half of its cells hold `wanted_per_cell`); empty if
  /// all is well.
  std::string sentence(std::uint64_t wanted_per_cell = 1) const;

 private:
  double width_px_ = 0.0, height_px_ = 0.0;
  std::uint64_t samples_ = 0;
  std::array<std::uint64_t, kCells> counts_{};
};

/// How often each two cameras saw the target at the same tick.
class Overlap {
 public:
  explicit Overlap(std::size_t cameras = 0) : cameras_(cameras), counts_(cameras * cameras, 0) {}

  std::size_t cameras() const noexcept { return cameras_; }
  /// The cameras that saw the target at one tick, each once.
  void add(std::span<const std::uint32_t> cameras) noexcept;
  /// All sightings of one tick, in the order of SampleSet.
  void add_tick(std::span<const Sighting> sightings) noexcept;

  /// Ticks that both saw; of a camera with itself, ticks that it saw at all.
  std::uint64_t ticks(std::size_t a, std::size_t b) const noexcept { return counts_[a * cameras_ + b]; }
  /// Cameras that are joined through pairs with at least `wanted_ticks` in common: largest group first, each
  /// in rising order. One group: all are connected.
  std::vector<std::vector<std::uint32_t>> groups(std::uint64_t wanted_ticks) const;
  /// One sentence for each camera or group that is not joined to the largest, saying what to do. Empty: all
  /// are connected. `names` has one name per camera.
  std::vector<std::string> sentences(std::span<const std::string> names, std::uint64_t wanted_ticks) const;

 private:
  std::size_t cameras_ = 0;
  std::vector<std::uint64_t> counts_;
};

/// Of all sightings; the set is in order.
std::vector<CoverageGrid> coverage_of(const SampleSet& samples);
Overlap overlap_of(const SampleSet& samples);

/// "a", "a and b", "a, b and c".
std::string list_in_words(std::span<const std::string> words);

}  // namespace glint
