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

}  // namespace
}  // namespace glint
