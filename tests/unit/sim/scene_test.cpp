// SPDX-License-Identifier: MIT
// The truth says who is seen by whom.
#include "host/sim/scene.hpp"

#include <gtest/gtest.h>

#include <bit>

namespace glint {
namespace {

TEST(Scene, SameTickSameTruthWhateverWasAskedBefore) {
  const Scene scene({});
  TickTruth first, second;
  scene.truth(100, first);
  scene.truth(3, second);
  scene.truth(100, second);
  for (std::uint32_t m = 0; m < scene.markers(); ++m) {
    EXPECT_EQ(first.markers[m].position_in_world, second.markers[m].position_in_world);
    EXPECT_EQ(first.markers[m].clean, second.markers[m].clean);
  }
}

TEST(Scene, AnotherSeedIsAnotherScene) {
  SimOptions options;
  options.seed = 2;
  TickTruth one, two;
  Scene({}).truth(0, one);
  Scene(options).truth(0, two);
  EXPECT_NE(one.markers[0].position_in_world, two.markers[0].position_in_world);
}

TEST(Scene, MostMarkersAreSeenByMostCameras) {
  const Scene scene({});
  TickTruth truth;
  int views = 0, clean = 0, two = 0, markers = 0;
  for (std::uint64_t tick = 0; tick < 300; tick += 3) {
    scene.truth(tick, truth);
    EXPECT_EQ(truth.delivered, 0xfu);
    for (const MarkerTruth& marker : truth.markers) {
      EXPECT_EQ(marker.clean & ~marker.visible, 0u);
      views += std::popcount(marker.visible);
      clean += std::popcount(marker.clean);
      two += std::popcount(marker.clean) >= 2 ? 1 : 0;
      ++markers;
    }
  }
  EXPECT_GT(views, 3 * markers);
  EXPECT_LT(clean, views);  // some blobs do touch
  EXPECT_GT(clean, views * 9 / 10);
  EXPECT_GT(two, markers * 95 / 100);
}

TEST(Scene, VisibleMarkersLieInTheImage) {
  const Scene scene({});
  TickTruth truth;
  for (std::uint64_t tick = 0; tick < 200; tick += 7) {
    scene.truth(tick, truth);
    for (std::uint32_t c = 0; c < 4; ++c) {
      const Camera camera(scene.calibration().cameras[c]);
      for (const MarkerTruth& marker : truth.markers) {
        const auto pixel = camera.project(marker.position_in_world);
        if ((marker.visible & (1u << c)) != 0) {
          ASSERT_TRUE(pixel.has_value());
          EXPECT_TRUE(camera.inside(*pixel, 2.0));
        }
      }
    }
  }
}

TEST(Scene, PolesHideMarkers) {
  SimOptions options;
  const Scene open(options);
  options.occluders = 12;
  const Scene wooded(options);
  TickTruth without, with;
  int seen_without = 0, seen_with = 0;
  for (std::uint64_t tick = 0; tick < 100; tick += 5) {
    open.truth(tick, without);
    wooded.truth(tick, with);
    for (std::uint32_t m = 0; m < open.markers(); ++m) {
      EXPECT_EQ(with.markers[m].visible & ~without.markers[m].visible, 0u);
      seen_without += std::popcount(without.markers[m].visible);
      seen_with += std::popcount(with.markers[m].visible);
    }
  }
  EXPECT_LT(seen_with, seen_without * 95 / 100);
  EXPECT_GT(seen_with, seen_without / 4);
}

TEST(Scene, ABumpTurnsTheCameraAndNotTheCalibration) {
  SimOptions options;
  options.faults.bump = SimBump{2, 50, 0.02};
  const Scene scene(options);
  const Eigen::Vector3d point(0.1, 0.2, 1.0);
  const Camera calibrated(scene.calibration().cameras[2]);
  const auto off = [&](std::uint64_t tick) {
    const sim::SimCamera& camera = scene.camera(2, tick);
    return (camera.project(camera.in_camera(point)) - calibrated.project(point).value()).norm();
  };
  EXPECT_LT(off(49), 1e-8);
  EXPECT_NEAR(off(50), 0.02 * 920.0, 0.5);
}

TEST(Scene, SwappedCamerasAreEachOther) {
  SimOptions options;
  options.faults.swap = SimSwap{1, 3, 20};
  options.faults.bump = SimBump{1, 0, 0.02};
  const Scene swapped(options);
  options.faults.swap.reset();
  const Scene straight(options);
  TickTruth truth, expected;
  for (const std::uint64_t tick : {19u, 20u, 40u}) {
    swapped.truth(tick, truth);
    straight.truth(tick, expected);
    const std::array<std::uint32_t, 4> taken_by =
        tick < 20 ? std::array<std::uint32_t, 4>{0, 1, 2, 3} : std::array<std::uint32_t, 4>{0, 3, 2, 1};
    for (std::uint32_t c = 0; c < 4; ++c) {
      EXPECT_EQ(swapped.behind(c, tick), taken_by[c]);
      for (std::uint32_t m = 0; m < swapped.markers(); ++m) {
        EXPECT_EQ(truth.views_of(c)[m].x_px, expected.views_of(taken_by[c])[m].x_px);
        EXPECT_EQ(truth.markers[m].visible >> c & 1u, expected.markers[m].visible >> taken_by[c] & 1u);
        EXPECT_EQ(truth.markers[m].clean >> c & 1u, expected.markers[m].clean >> taken_by[c] & 1u);
      }
    }
  }
}

TEST(Scene, ADelayedCameraSeesWhatTheOthersSeeLater) {
  SimOptions options;
  const Scene straight(options);
  options.faults.delay = SimDelay{2, 10, 2.0 / options.rate_hz};
  const Scene scene(options);
  TickTruth now, later;
  for (const std::uint64_t tick : {9u, 10u, 50u}) {
    scene.truth(tick, now);
    EXPECT_NEAR(scene.mid_exposure_s(2, tick) - scene.mid_exposure_s(tick), tick < 10 ? 0.0 : 2.0 / 90.0,
                1e-12);
    straight.truth(tick < 10 ? tick : tick + 2, later);
    for (std::uint32_t m = 0; m < scene.markers(); ++m)
      EXPECT_NEAR(now.views_of(2)[m].x_px, later.views_of(2)[m].x_px, 1e-6);
    straight.truth(tick, later);
    for (std::uint32_t m = 0; m < scene.markers(); ++m) {
      EXPECT_EQ(now.views_of(1)[m].x_px, later.views_of(1)[m].x_px);
      EXPECT_EQ(now.markers[m].position_in_world, later.markers[m].position_in_world);
    }
  }
}

}  // namespace
}  // namespace glint
