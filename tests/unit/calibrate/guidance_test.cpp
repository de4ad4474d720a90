// SPDX-License-Identifier: MIT
// What is said while a wand is waved before the simulated rig.
#include "host/calibrate/guidance.hpp"

#include <cmath>
#include <random>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "host/sim/rig.hpp"

namespace glint {
namespace {

using testing::Contains;
using testing::Each;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::Not;
using testing::StartsWith;

struct Rig {
  Calibration calibration = sim_calibration({});
  std::vector<Camera> cameras;
  std::vector<SampleCamera> sample_cameras;
  Target wand = wand_target({0.0, 0.13, 0.39}, 0.0063);
  std::mt19937_64 random{7};

  Rig() {
    for (const CameraCalibration& c : calibration.cameras) {
      cameras.emplace_back(c);
      sample_cameras.push_back({c.name, c.width_px, c.height_px});
    }
  }

  double uniform(double low, double high) {
    return std::uniform_real_distribution<double>(low, high)(random);
  }

  /// The wand at a place, in all cameras that see it but those in `blind`.
  std::vector<Sighting> tick(std::uint64_t number, const Eigen::Vector3d& at, const Eigen::Vector3d& axis,
                             std::uint32_t blind = 99) {
    std::normal_distribution<double> noise(0.0, 0.1);
    std::vector<Sighting> sightings;
    for (std::uint32_t camera = 0; camera < cameras.size(); ++camera) {
      for (std::uint32_t point = 0; point < 3 && camera != blind; ++point) {
        const auto pixel = cameras[camera].project(at + wand.points_in_target[point].x() * axis.normalized());
        if (pixel && cameras[camera].inside(*pixel))
          sightings.push_back(
              {number, camera, point, *pixel + Eigen::Vector2d(noise(random), noise(random))});
      }
    }
    return sightings;
  }

  /// Anywhere in the volume; height_m: only at this height.
  std::vector<Sighting> anywhere(std::uint64_t number, double height_m = 0.0, std::uint32_t blind = 99) {
    const bool flat = height_m > 0;
    return tick(number, {uniform(-2, 2), uniform(-2, 2), flat ? height_m : uniform(0.05, 2.2)},
                {uniform(-1, 1), uniform(-1, 1), flat ? 0.0 : uniform(-1, 1)}, blind);
  }
};

TEST(Guidance, StartsByAskingForTheTarget) {
  Rig rig;
  const Guidance guidance(rig.wand, rig.sample_cameras, rig.calibration.cameras);
  const GuidanceState state = guidance.state();
  EXPECT_FALSE(state.ready);
  EXPECT_EQ(state.progress, 0.0);
  ASSERT_EQ(state.blocking.size(), 4u);
  EXPECT_THAT(state.blocking, Each(HasSubstr("has not seen the target")));
}

TEST(Guidance, IsReadyAfterAGoodDance) {
  Rig rig;
  Guidance guidance(rig.wand, rig.sample_cameras, rig.calibration.cameras);
  double before = 0.0;
  std::uint64_t number = 0;
  for (int part = 0; part < 6; ++part) {
    for (int i = 0; i < 600; ++i, ++number) guidance.add(rig.anywhere(number));
    EXPECT_GE(guidance.state().progress, before) << "progress never goes back";
    before = guidance.state().progress;
  }
  const GuidanceState state = guidance.state();
  EXPECT_THAT(state.sentences, IsEmpty());
  EXPECT_TRUE(state.ready);
  EXPECT_EQ(state.progress, 1.0);
  EXPECT_EQ(guidance.ticks(), 3600u);
  EXPECT_THAT(guidance.status_line(), HasSubstr("cam1 100 %  cam2 100 %  cam3 100 %  cam4 100 %  |  enough"));
}

TEST(Guidance, ATargetAtRestIsOneSample) {
  Rig rig;
  Guidance guidance(rig.wand, rig.sample_cameras);
  for (std::uint64_t i = 0; i < 2000; ++i) guidance.add(rig.tick(i, {0, 0, 1}, {1, 0, 0}));
  EXPECT_EQ(guidance.ticks(), 2000u);
  for (const CameraProgress& camera : guidance.state().cameras) EXPECT_EQ(camera.ticks, 1u) << camera.name;
  EXPECT_THAT(guidance.state().blocking, Contains(HasSubstr("has 1 sample, and at least 100 are needed")));
}

TEST(Guidance, NamesTheCameraThatSeesNothing) {
  Rig rig;
  Guidance guidance(rig.wand, rig.sample_cameras, rig.calibration.cameras);
  for (std::uint64_t i = 0; i < 3000; ++i) guidance.add(rig.anywhere(i, 0.0, 2));
  const GuidanceState state = guidance.state();
  EXPECT_THAT(state.blocking, ElementsAre(StartsWith("cam3 has not seen the target")));
  EXPECT_EQ(state.cameras[2].progress, 0.0);
  EXPECT_EQ(state.cameras[1].progress, 1.0);
  EXPECT_THAT(guidance.status_line(), HasSubstr("cam3 0 %"));
}

TEST(Guidance, NamesTheCameraThatSharesNoView) {
  Rig rig;
  Guidance guidance(rig.wand, rig.sample_cameras, rig.calibration.cameras);
  for (std::uint64_t i = 0; i < 4000; ++i) {
    std::vector<Sighting> tick = rig.anywhere(i);
    // cam4 sees it only when nobody else does
    std::erase_if(tick, [&](const Sighting& s) { return (s.camera == 3) != (i % 2 == 0); });
    guidance.add(tick);
  }
  EXPECT_THAT(guidance.state().blocking, ElementsAre(HasSubstr("cam4 shares no view with any other camera")));
}

TEST(Guidance, NamesThePartOfTheImageThatLacks) {
  Rig rig;
  Guidance guidance(rig.wand, rig.sample_cameras, rig.calibration.cameras);
  for (std::uint64_t i = 0; i < 4000; ++i) {
    std::vector<Sighting> tick = rig.anywhere(i);
    std::erase_if(tick, [](const Sighting& s) { return s.camera == 1 && s.pixel.x() < 700; });
    guidance.add(tick);
  }
  const GuidanceState state = guidance.state();
  EXPECT_FALSE(state.ready);
  EXPECT_THAT(state.blocking, IsEmpty());
  EXPECT_THAT(state.sentences, Contains("cam2: nothing yet in the left of the image"));
}

TEST(Guidance, NoticesAPlaneFromTheImagesAlone) {
  Rig rig;
  Guidance flat(rig.wand, rig.sample_cameras, rig.calibration.cameras);
  for (std::uint64_t i = 0; i < 4000; ++i) flat.add(rig.anywhere(i, 1.0));
  EXPECT_THAT(flat.state().sentences, Contains(HasSubstr("all samples lie in one plane")));
  EXPECT_FALSE(flat.state().ready);
  for (std::uint64_t i = 4000; i < 8000; ++i) flat.add(rig.anywhere(i));
  EXPECT_THAT(flat.state().sentences, Not(Contains(HasSubstr("plane")))) << "and notices the remedy";
}

TEST(Guidance, OfManyCamerasTheLineNamesTheLeast) {
  std::vector<SampleCamera> cameras;
  for (int i = 1; i <= 16; ++i) cameras.push_back({"camera" + std::to_string(i), 1280, 800});
  Guidance guidance(GuidanceWants{}, cameras);
  EXPECT_THAT(guidance.status_line(),
              StartsWith("0 of 16 cameras ready, least camera1 0 %  |  camera1 has not seen"));
  EXPECT_LE(guidance.status_line(60).size(), 60u);
  EXPECT_THAT(guidance.status_line(60), testing::EndsWith("..."));
}

TEST(Guidance, ABoardNeedsFewerTicks) {
  Target board;
  board.kind = TargetKind::Board;
  EXPECT_LT(wants_for(board).ticks, wants_for(marker_target(0.006)).ticks);
}

TEST(Spread, TellsLinesAndPlanesFromVolumes) {
  std::mt19937_64 random(3);
  std::normal_distribution<double> normal;
  const auto cloud = [&](double a, double b, double c) {
    std::vector<Eigen::Vector3d> points;
    const Eigen::Matrix3d turn =
        Eigen::AngleAxisd(0.7, Eigen::Vector3d(1, 2, 3).normalized()).toRotationMatrix();
    for (int i = 0; i < 4000; ++i)
      points.push_back(turn * Eigen::Vector3d(a * normal(random), b * normal(random), c * normal(random)) +
                       Eigen::Vector3d(1, 1, 1));
    return points;
  };
  const Eigen::Vector3d sd = principal_spread_m(cloud(0.5, 2.0, 1.0));
  EXPECT_NEAR(sd[0], 2.0, 0.1);
  EXPECT_NEAR(sd[1], 1.0, 0.05);
  EXPECT_NEAR(sd[2], 0.5, 0.03);
  EXPECT_EQ(spread_sentence(cloud(0.5, 2.0, 1.0)), "");
  EXPECT_THAT(spread_sentence(cloud(2.0, 2.0, 0.01)), HasSubstr("in one plane"));
  EXPECT_THAT(spread_sentence(cloud(2.0, 0.01, 0.01)), HasSubstr("on one line"));
  EXPECT_THAT(spread_sentence({}), HasSubstr("at one place"));
}

}  // namespace
}  // namespace glint
