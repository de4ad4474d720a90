// SPDX-License-Identifier: MIT
// Counts per cell and per pair of cameras, and the words for what is missing.
#include "host/calibrate/coverage.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>

namespace glint {
namespace {

/// Which third of the image a column or row belongs to: of 8 columns 3, 2 and 3, of 5 rows 2, 1 and 2.
constexpr std::size_t third_of(std::size_t cell, std::size_t cells) noexcept {
  const std::size_t outer = (cells + 1) / 3;  // the edges need samples most, so the middle is the smallest
  return cell < outer ? 0 : cell >= cells - outer ? 2 : 1;
}
static_assert(third_of(2, 8) == 0 && third_of(3, 8) == 1 && third_of(4, 8) == 1 && third_of(5, 8) == 2);
static_assert(third_of(1, 5) == 0 && third_of(2, 5) == 1 && third_of(3, 5) == 2);

using Thirds = std::array<std::array<bool, 3>, 3>;  // [row][column]: too little is there

std::vector<std::string> names_of(Thirds missing) {
  std::vector<std::string> names;
  const auto all = [](bool a, bool b, bool c) { return a && b && c; };
  const bool top = all(missing[0][0], missing[0][1], missing[0][2]);
  const bool bottom = all(missing[2][0], missing[2][1], missing[2][2]);
  const bool left = all(missing[0][0], missing[1][0], missing[2][0]);
  const bool right = all(missing[0][2], missing[1][2], missing[2][2]);
  if (top && bottom && left && right && missing[1][1]) return {"all"};
  if (top) names.emplace_back("the top");
  if (bottom) names.emplace_back("the bottom");
  if (left) names.emplace_back("the left");
  if (right) names.emplace_back("the right");
  constexpr std::array<std::array<const char*, 3>, 3> kNames{
      {{"the upper left", "the upper middle", "the upper right"},
       {"the left middle", "the middle", "the right middle"},
       {"the lower left", "the lower middle", "the lower right"}}};
  for (std::size_t row = 0; row < 3; ++row) {
    for (std::size_t column = 0; column < 3; ++column) {
      const bool said =
          (top && row == 0) || (bottom && row == 2) || (left && column == 0) || (right && column == 2);
      if (missing[row][column] && !said) names.emplace_back(kNames[row][column]);
    }
  }
  return names;
}

std::uint32_t root_of(std::vector<std::uint32_t>& parent, std::uint32_t camera) {
  while (parent[camera] != camera) camera = parent[camera] = parent[parent[camera]];
  return camera;
}

}  // namespace

void CoverageGrid::add(const Eigen::Vector2d& pixel) noexcept {
  if (!pixel.allFinite() || width_px_ <= 0 || height_px_ <= 0) return;
  // Pixel centres are whole numbers, so the image begins at -0.5.
  const auto cell = [](double place, double extent, std::size_t cells) {
    const double at = std::floor((place + 0.5) / extent * static_cast<double>(cells));
    return static_cast<std::size_t>(std::clamp(at, 0.0, static_cast<double>(cells - 1)));
  };
  ++counts_[cell(pixel.y(), height_px_, kRows) * kColumns + cell(pixel.x(), width_px_, kColumns)];
  ++samples_;
}

double CoverageGrid::share(std::uint64_t wanted_per_cell) const noexcept {
  const auto filled = std::count_if(counts_.begin(), counts_.end(),
                                    [&](std::uint64_t count) { return count >= wanted_per_cell; });
  return static_cast<double>(filled) / static_cast<double>(kCells);
}

double CoverageGrid::fill(std::uint64_t wanted_per_cell) const noexcept {
  if (wanted_per_cell == 0) return 1.0;
  std::uint64_t useful = 0;
  for (const std::uint64_t count : counts_) useful += std::min(count, wanted_per_cell);
  return static_cast<double>(useful) / static_cast<double>(wanted_per_cell * kCells);
}

std::string CoverageGrid::sentence(std::uint64_t wanted_per_cell) const {
  if (samples_ == 0) return "nothing yet: it has not seen the target";
  std::array<std::array<int, 3>, 3> cells{}, seen{}, filled{};
  for (std::size_t row = 0; row < kRows; ++row) {
    for (std::size_t column = 0; column < kColumns; ++column) {
      const std::size_t r = third_of(row, kRows), c = third_of(column, kColumns);
      ++cells[r][c];
      if (count(column, row) > 0) ++seen[r][c];
      if (count(column, row) >= wanted_per_cell) ++filled[r][c];
    }
  }
  Thirds nothing{}, little{};
  for (std::size_t r = 0; r < 3; ++r) {
    for (std::size_t c = 0; c < 3; ++c) {
      nothing[r][c] = seen[r][c] == 0;
      little[r][c] = 2 * filled[r][c] < cells[r][c];
    }
  }
  if (const auto names = names_of(nothing); !names.empty())
    return "nothing yet in " + list_in_words(names) + " of the image";
  if (const auto names = names_of(little); !names.empty())
    return "too little yet in " + list_in_words(names) + " of the image";
  return {};
}

void Overlap::add(std::span<const std::uint32_t> cameras) noexcept {
  for (const std::uint32_t a : cameras) {
    for (const std::uint32_t b : cameras) {
      if (a < cameras_ && b < cameras_) ++counts_[a * cameras_ + b];
    }
  }
}

void Overlap::add_tick(std::span<const Sighting> sightings) noexcept {
  // By camera, so a camera is new where it differs from the sighting before.
  for (std::size_t i = 0; i < sightings.size(); ++i) {
    const std::uint32_t a = sightings[i].camera;
    if (a >= cameras_ || (i > 0 && sightings[i - 1].camera == a)) continue;
    for (std::size_t j = 0; j < sightings.size(); ++j) {
      const std::uint32_t b = sightings[j].camera;
      if (b < cameras_ && (j == 0 || sightings[j - 1].camera != b)) ++counts_[a * cameras_ + b];
    }
  }
}

std::vector<std::vector<std::uint32_t>> Overlap::groups(std::uint64_t wanted_ticks) const {
  std::vector<std::uint32_t> parent(cameras_);
  std::iota(parent.begin(), parent.end(), 0u);
  for (std::uint32_t a = 0; a < cameras_; ++a) {
    for (std::uint32_t b = a + 1; b < cameras_; ++b) {
      if (ticks(a, b) >= wanted_ticks) parent[root_of(parent, a)] = root_of(parent, b);
    }
  }
  std::vector<std::vector<std::uint32_t>> by_root(cameras_), groups;
  for (std::uint32_t camera = 0; camera < cameras_; ++camera)
    by_root[root_of(parent, camera)].push_back(camera);
  for (auto& group : by_root) {
    if (!group.empty()) groups.push_back(std::move(group));
  }
  std::sort(groups.begin(), groups.end(), [](const auto& a, const auto& b) {
    return a.size() != b.size() ? a.size() > b.size() : a.front() < b.front();
  });
  return groups;
}

std::vector<std::string> Overlap::sentences(std::span<const std::string> names,
                                            std::uint64_t wanted_ticks) const {
  std::vector<std::string> sentences;
  const auto all = groups(wanted_ticks);
  for (std::size_t g = 0; g < all.size(); ++g) {
    // The largest group is what the others are measured by, unless it is a camera that is blind like them.
    if (g == 0 && (all[g].size() > 1 || ticks(all[g].front(), all[g].front()) > 0)) continue;
    std::uint64_t best = 0;
    std::uint32_t inside = all[g].front(), outside = all[0].front();
    bool seen = false;
    for (const std::uint32_t a : all[g]) {
      seen = seen || ticks(a, a) > 0;
      for (std::uint32_t b = 0; b < cameras_; ++b) {
        if (std::find(all[g].begin(), all[g].end(), b) != all[g].end() || ticks(a, b) <= best) continue;
        best = ticks(a, b);
        inside = a;
        outside = b;
      }
    }
    std::vector<std::string> group;
    for (const std::uint32_t camera : all[g]) group.push_back(names[camera]);
    const std::string who = list_in_words(group);
    const bool one = group.size() == 1;
    if (!seen) {
      sentences.push_back(who + (one ? " has" : " have") +
                          " not seen the target: show it there, and check the lens cap, the exposure and the "
                          "threshold if nothing appears");
    } else if (best == 0) {
      sentences.push_back(who + (one ? " shares" : " share") +
                          " no view with any other camera: show the target where " +
                          (one ? "it" : "one of them") + " and a neighbour both see it");
    } else {
      const std::string shared = std::to_string(best) + (best == 1 ? " tick" : " ticks");
      sentences.push_back(who + (one ? " is" : " are") + " hardly connected to the others (" + shared +
                          " of " + names[inside] + " with " + names[outside] + ", " +
                          std::to_string(wanted_ticks) + " wanted): show the target where both see it");
    }
  }
  return sentences;
}

std::vector<CoverageGrid> coverage_of(const SampleSet& samples) {
  std::vector<CoverageGrid> grids;
  for (const SampleCamera& camera : samples.cameras) grids.emplace_back(camera.width_px, camera.height_px);
  for (const Sighting& sighting : samples.sightings) {
    if (sighting.camera < grids.size()) grids[sighting.camera].add(sighting.pixel);
  }
  return grids;
}

Overlap overlap_of(const SampleSet& samples) {
  Overlap overlap(samples.cameras.size());
  for (const SampleTick& tick : ticks_of(samples)) overlap.add_tick(tick.sightings);
  return overlap;
}

std::string list_in_words(std::span<const std::string> words) {
  std::string list;
  for (std::size_t i = 0; i < words.size(); ++i) {
    if (i > 0) list += i + 1 == words.size() ? " and " : ", ";
    list += words[i];
  }
  return list;
}

}  // namespace glint
