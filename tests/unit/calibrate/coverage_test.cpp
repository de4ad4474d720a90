// SPDX-License-Identifier: MIT
// Cells, words for what is missing, and cameras that share no view.
#include "host/calibrate/coverage.hpp"

#include <limits>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace glint {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

/// Fills the cells for which `wanted(column, row)` holds.
template <typename Wanted>
CoverageGrid filled(int times, Wanted wanted) {
  CoverageGrid grid(1280, 800);
  for (std::size_t row = 0; row < CoverageGrid::kRows; ++row) {
    for (std::size_t column = 0; column < CoverageGrid::kColumns; ++column) {
      for (int i = 0; i < times && wanted(column, row); ++i)
        grid.add({160.0 * static_cast<double>(column) + 79.5, 160.0 * static_cast<double>(row) + 79.5});
    }
  }
  return grid;
}

TEST(CoverageGrid, CountsWherePixelsLie) {
  CoverageGrid grid(1280, 800);
  grid.add({-0.5, -0.5});
  grid.add({159.49, 159.49});  // still the first cell: the image begins at -0.5
  grid.add({159.51, 159.49});
  grid.add({1279.4, 799.4});
  grid.add({1300.0, -20.0});  // just outside counts for the nearest
  grid.add({std::numeric_limits<double>::quiet_NaN(), 10.0});
  EXPECT_EQ(grid.count(0, 0), 2u);
  EXPECT_EQ(grid.count(1, 0), 1u);
  EXPECT_EQ(grid.count(7, 4), 1u);
  EXPECT_EQ(grid.count(7, 0), 1u);
  EXPECT_EQ(grid.samples(), 5u);
  EXPECT_DOUBLE_EQ(grid.share(), 4.0 / 40.0);
  EXPECT_DOUBLE_EQ(grid.share(2), 1.0 / 40.0);
  EXPECT_DOUBLE_EQ(grid.fill(2), 5.0 / 80.0);
}

TEST(CoverageGrid, SaysNothingOfAFullImage) {
  const CoverageGrid grid = filled(3, [](auto, auto) { return true; });
  EXPECT_EQ(grid.sentence(3), "");
  EXPECT_DOUBLE_EQ(grid.fill(3), 1.0);
  EXPECT_EQ(grid.sentence(4), "too little yet in all of the image");
}

TEST(CoverageGrid, NamesACorner) {
  const CoverageGrid grid =
      filled(1, [](std::size_t column, std::size_t row) { return column > 2 || row < 3; });
  EXPECT_EQ(grid.sentence(), "nothing yet in the lower left of the image");
}

TEST(CoverageGrid, ARegionWithoutHalfOfItsCellsHasTooLittle) {
  const CoverageGrid grid =
      filled(1, [](std::size_t column, std::size_t row) { return column > 2 || row < 4; });
  EXPECT_EQ(grid.sentence(), "");
  const CoverageGrid few =
      filled(1, [](std::size_t column, std::size_t row) { return column > 1 || row < 3; });
  EXPECT_EQ(few.sentence(), "too little yet in the lower left of the image");
}

TEST(CoverageGrid, NamesWholeEdgesOnce) {
  const CoverageGrid edge = filled(1, [](std::size_t column, std::size_t) { return column < 5; });
  EXPECT_EQ(edge.sentence(), "nothing yet in the right of the image");
  const CoverageGrid middle =
      filled(1, [](std::size_t column, std::size_t row) { return column > 2 && column < 5 && row == 2; });
  EXPECT_EQ(middle.sentence(), "nothing yet in the top, the bottom, the left and the right of the image");
}

TEST(CoverageGrid, TellsLittleFromNothing) {
  CoverageGrid grid = filled(1, [](auto, auto) { return true; });
  for (int i = 0; i < 9; ++i) grid.add({79.5, 79.5});
  EXPECT_THAT(grid.sentence(2), HasSubstr("too little yet in"));
  EXPECT_EQ(CoverageGrid(1280, 800).sentence(), "nothing yet: it has not seen the target");
}

Overlap overlap_of_ticks(std::size_t cameras, const std::vector<std::vector<std::uint32_t>>& ticks,
                         int times) {
  Overlap overlap(cameras);
  for (int i = 0; i < times; ++i) {
    for (const auto& tick : ticks) overlap.add(tick);
  }
  return overlap;
}

TEST(Overlap, CountsPairsOfATickOnce) {
  Overlap overlap(3);
  std::vector<Sighting> tick;
  for (const std::uint32_t camera : {0u, 2u}) {
    for (std::uint32_t point = 0; point < 3; ++point) tick.push_back({7, camera, point, {1, 2}});
  }
  overlap.add_tick(tick);
  EXPECT_EQ(overlap.ticks(0, 2), 1u);
  EXPECT_EQ(overlap.ticks(2, 0), 1u);
  EXPECT_EQ(overlap.ticks(0, 0), 1u);
  EXPECT_EQ(overlap.ticks(1, 1), 0u);
  EXPECT_EQ(overlap.ticks(0, 1), 0u);
}

TEST(Overlap, JoinsThroughOthers) {
  const Overlap chain = overlap_of_ticks(4, {{0, 1}, {1, 2}, {2, 3}}, 10);
  EXPECT_THAT(chain.groups(10), ElementsAre(ElementsAre(0, 1, 2, 3)));
  EXPECT_EQ(chain.groups(11).size(), 4u);
  const std::vector<std::string> names{"a", "b", "c", "d"};
  EXPECT_THAT(chain.sentences(names, 10), IsEmpty());
}

TEST(Overlap, NamesTheCameraThatSharesNoView) {
  const Overlap overlap = overlap_of_ticks(4, {{0, 1, 2}, {3}}, 50);
  const std::vector<std::string> names{"cam1", "cam2", "cam3", "cam4"};
  EXPECT_THAT(overlap.groups(20), ElementsAre(ElementsAre(0, 1, 2), ElementsAre(3)));
  EXPECT_THAT(
      overlap.sentences(names, 20),
      ElementsAre("cam4 shares no view with any other camera: show the target where it and a neighbour both "
                  "see it"));
}

TEST(Overlap, NamesTheWeakestLinkAndTheBlindCamera) {
  Overlap overlap = overlap_of_ticks(5, {{0, 1}, {2, 3}}, 50);
  for (int i = 0; i < 7; ++i) overlap.add(std::vector<std::uint32_t>{1, 3});
  const std::vector<std::string> names{"n", "e", "s", "w", "top"};
  EXPECT_THAT(
      overlap.sentences(names, 20),
      ElementsAre(HasSubstr("s and w are hardly connected to the others (7 ticks of w with e, 20 wanted)"),
                  HasSubstr("top has not seen the target")));
}

TEST(Coverage, OfASampleSet) {
  SampleSet samples;
  samples.cameras = {{"a", 640, 480}, {"b", 640, 480}};
  samples.sightings = {{1, 0, 0, {10, 10}}, {1, 1, 0, {600, 400}}, {2, 0, 0, {10, 10}}};
  const auto grids = coverage_of(samples);
  ASSERT_EQ(grids.size(), 2u);
  EXPECT_EQ(grids[0].count(0, 0), 2u);
  EXPECT_EQ(grids[1].samples(), 1u);
  EXPECT_EQ(overlap_of(samples).ticks(0, 1), 1u);
  EXPECT_EQ(overlap_of(samples).ticks(0, 0), 2u);
}

}  // namespace
}  // namespace glint
