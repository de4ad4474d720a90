// SPDX-License-Identifier: MIT
// Bumped, swapped and late cameras are named, rightly and within two seconds, over many rigs and times.
#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>
#include <functional>
#include <numbers>

#include "tests/unit/health/watched_rig.hpp"

namespace glint::testing {
namespace {

constexpr double kDegree = std::numbers::pi / 180.0;
constexpr unsigned kSeeds = 20, kLeastNamed = 19;
constexpr double kNamedWithin_s = 2.0;

/// When the fault comes: another time for each seed.
std::uint64_t fault_tick(unsigned seed) { return 120 + 37 * (seed % 7); }
std::uint32_t fault_camera(unsigned seed) { return seed % 4; }

/// The first word on a camera, within two seconds of the fault, is right; and there is none on another
/// camera.
struct Verdict {
  bool named = false, wrong = false;
  double after_s = 0.0;
  std::string text;
};

Verdict run_with_fault(WatchedRigOptions options, unsigned seed,
                       const std::function<bool(const HealthEvent&)>& right) {
  WatchedRig rig(options);
  const double fault_s = static_cast<double>(fault_tick(seed)) / options.sim.rate_hz;
  rig.run(fault_s + kNamedWithin_s);
  Verdict verdict;
  verdict.text = "seed " + std::to_string(seed) + ", fault at " + std::to_string(fault_s) +
                 " s: " + text_of(rig.events());
  for (const NamedEvent& e : rig.events()) {
    const bool is_right = e.time_s >= fault_s && right(e.event);
    if (is_right && !verdict.named) verdict.after_s = e.time_s - fault_s;
    verdict.named = verdict.named || is_right;
    verdict.wrong = verdict.wrong || !is_right;
  }
  return verdict;
}

/// Counts how many seeds are named rightly, and prints it.
unsigned named(const char* what, const std::function<void(WatchedRigOptions&, unsigned)>& spoil,
               const std::function<bool(const HealthEvent&, unsigned)>& right) {
  unsigned count = 0;
  double slowest_s = 0.0;
  for (unsigned seed = 1; seed <= kSeeds; ++seed) {
    WatchedRigOptions options;
    options.sim.seed = seed;
    spoil(options, seed);
    const Verdict verdict =
        run_with_fault(options, seed, [&](const HealthEvent& event) { return right(event, seed); });
    slowest_s = std::max(slowest_s, verdict.after_s);
    if (verdict.named && !verdict.wrong)
      ++count;
    else
      std::printf("%s\n", verdict.text.c_str());
  }
  std::printf("%s: %u of %u named, the slowest after %.2f s\n", what, count, kSeeds, slowest_s);
  return count;
}

TEST(HealthFaults, ABumpOfAFifthOfADegreeIsNamed) {
  const auto angle = [](unsigned seed) { return (seed % 2 == 0 ? 0.2 : -0.2) * kDegree; };
  EXPECT_GE(named(
                "bump",
                [&](WatchedRigOptions& o, unsigned seed) {
                  o.sim.faults.bump = SimBump{fault_camera(seed), fault_tick(seed), angle(seed)};
                },
                [&](const HealthEvent& e, unsigned seed) {
                  return e.state.condition == CameraCondition::Bumped &&
                         index(e.camera) == fault_camera(seed) &&
                         (e.state.turn_rad - Eigen::Vector3d(0.0, angle(seed), 0.0)).norm() < 0.02 * kDegree;
                }),
            kLeastNamed);
}

TEST(HealthFaults, SwappedCamerasAreNamed) {
  const auto partner = [](unsigned seed) { return (fault_camera(seed) + 1 + seed / 4 % 3) % 4; };
  EXPECT_GE(named(
                "swap",
                [&](WatchedRigOptions& o, unsigned seed) {
                  o.sim.faults.swap = SimSwap{fault_camera(seed), partner(seed), fault_tick(seed)};
                },
                [&](const HealthEvent& e, unsigned seed) {
                  const std::size_t a = index(e.camera), b = index(e.state.swapped_with);
                  return e.state.condition == CameraCondition::Swapped &&
                         std::min(a, b) == std::min(fault_camera(seed), partner(seed)) &&
                         std::max(a, b) == std::max(fault_camera(seed), partner(seed));
                }),
            kLeastNamed);
}

TEST(HealthFaults, ADelayOfEightMillisecondsIsNamed) {
  EXPECT_GE(named(
                "delay",
                [&](WatchedRigOptions& o, unsigned seed) {
                  o.sim.faults.delay = SimDelay{fault_camera(seed), fault_tick(seed), 0.008};
                },
                [&](const HealthEvent& e, unsigned seed) {
                  return e.state.condition == CameraCondition::Late &&
                         index(e.camera) == fault_camera(seed) && std::abs(e.state.late_s - 0.008) < 0.3e-3;
                }),
            kLeastNamed);
}

TEST(HealthFaults, GoodCamerasAreNever) {
  double watch_s = 0.0, ticks = 0.0;
  for (unsigned seed = 1; seed <= kSeeds; ++seed) {
    WatchedRigOptions options;
    options.sim.seed = seed;
    WatchedRig rig(options);
    rig.run(6.0);
    EXPECT_TRUE(rig.events().empty()) << "seed " << seed << ": " << text_of(rig.events());
    for (const CameraReport& camera : rig.health().report().cameras) {
      EXPECT_TRUE(camera.green());
      EXPECT_GT(camera.compared, 500u);
      EXPECT_GT(camera.agreed, camera.compared * 9 / 10);
      // 0.04 px of noise where 0.05 px are allowed.
      EXPECT_NEAR(camera.residual_px, 0.8 * camera.expected_px, 0.15 * camera.expected_px);
    }
    watch_s += rig.watch_s();
    ticks += static_cast<double>(rig.ticks());
  }
  std::printf("the watch takes %.1f us of an exposure\n", 1e6 * watch_s / ticks);
}

/// The rig of seed 3 whose third camera was turned by that vector before the start.
std::vector<NamedEvent> turned_from_the_start(const Eigen::Vector3d& turn_rad) {
  WatchedRigOptions options;
  options.sim.seed = 3;
  Calibration told = Scene(options.sim).calibration();
  Pose& pose = told.cameras[2].world_from_camera;
  pose.rotation = (pose.rotation *
                   Eigen::Quaterniond(Eigen::AngleAxisd(turn_rad.norm(), turn_rad.normalized())).conjugate())
                      .normalized();
  options.calibration = told;
  WatchedRig rig(options);
  rig.run(2.0);
  return rig.events();
}

TEST(HealthFaults, BumpsInAllDirectionsAreMeasured) {
  for (const Eigen::Vector3d& degrees :
       {Eigen::Vector3d(0.2, 0.0, 0.0), Eigen::Vector3d(-0.5, 0.3, 0.0), Eigen::Vector3d(0.0, 0.0, 0.6),
        Eigen::Vector3d(0.05, -0.05, -0.1), Eigen::Vector3d(2.0, 3.0, 1.0)}) {
    const std::vector<NamedEvent> events = turned_from_the_start(degrees * kDegree);
    ASSERT_EQ(events.size(), 1u) << degrees.transpose() << ": " << text_of(events);
    EXPECT_EQ(index(events[0].event.camera), 2u);
    EXPECT_EQ(events[0].event.state.condition, CameraCondition::Bumped);
    const Eigen::Vector3d found = events[0].event.state.turn_rad / kDegree;
    EXPECT_LT((found - degrees).norm(), 0.01 + 0.02 * degrees.norm()) << found.transpose();
  }
}

TEST(HealthFaults, DelaysOfAllSizesAreMeasured) {
  for (const double late_ms : {-8.0, 2.0, 1e3 / 90.0, -20.0, 2e3 / 90.0}) {
    WatchedRigOptions options;
    options.sim.seed = 5;
    options.sim.faults.delay = SimDelay{1, 0, late_ms * 1e-3};
    WatchedRig rig(options);
    rig.run(2.0);
    ASSERT_EQ(rig.events().size(), 1u) << late_ms << ": " << text_of(rig.events());
    EXPECT_EQ(index(rig.events()[0].event.camera), 1u);
    EXPECT_EQ(rig.events()[0].event.state.condition, CameraCondition::Late);
    EXPECT_NEAR(rig.events()[0].event.state.late_s * 1e3, late_ms, 0.2 + 0.03 * std::abs(late_ms));
  }
}

TEST(HealthFaults, OneMarkerIsEnough) {
  unsigned named = 0;
  for (unsigned seed = 1; seed <= 5; ++seed) {
    WatchedRigOptions options;
    options.sim.seed = seed;
    options.sim.markers = 1;
    WatchedRigOptions bumped = options, swapped = options, late = options;
    bumped.sim.faults.bump = SimBump{0, fault_tick(seed), 0.2 * kDegree};
    swapped.sim.faults.swap = SimSwap{0, 2, fault_tick(seed)};
    late.sim.faults.delay = SimDelay{0, fault_tick(seed), 0.008};
    const auto is = [](CameraCondition condition) {
      return [condition](const HealthEvent& e) {
        return e.state.condition == condition && index(e.camera) % 2 == 0;
      };
    };
    for (const auto& [rig, condition] :
         {std::pair{bumped, CameraCondition::Bumped}, std::pair{swapped, CameraCondition::Swapped},
          std::pair{late, CameraCondition::Late}}) {
      const Verdict verdict = run_with_fault(rig, seed, is(condition));
      EXPECT_FALSE(verdict.wrong) << verdict.text;
      named += verdict.named ? 1u : 0u;
    }
  }
  EXPECT_GE(named, 13u) << "of 15; the marker may be where the camera does not see it";
}

TEST(HealthFaults, ThreeCamerasAreEnoughForABumpAndADelay) {
  WatchedRigOptions options;
  options.sim.cameras = 3;
  WatchedRigOptions late = options;
  options.sim.faults.bump = SimBump{1, fault_tick(1), 0.2 * kDegree};
  late.sim.faults.delay = SimDelay{1, fault_tick(1), -0.008};
  for (const auto& [rig, condition] :
       {std::pair{options, CameraCondition::Bumped}, std::pair{late, CameraCondition::Late}}) {
    const Verdict verdict = run_with_fault(rig, 1, [c = condition](const HealthEvent& e) {
      return e.state.condition == c && index(e.camera) == 1;
    });
    EXPECT_TRUE(verdict.named && !verdict.wrong) << verdict.text;
  }
}

TEST(HealthFaults, TwoOfThreeCamerasAreFoundSwapped) {
  for (unsigned seed = 1; seed <= 6; ++seed) {
    WatchedRigOptions options;
    options.sim.seed = seed;
    options.sim.cameras = 3;
    if (seed > 4) options.sim.markers = 3;
    const std::uint32_t a = seed % 3, b = (seed + 1) % 3;
    options.sim.faults.swap = SimSwap{a, b, fault_tick(seed)};
    const Verdict verdict = run_with_fault(options, seed, [&](const HealthEvent& e) {
      const std::size_t one = index(e.camera), other = index(e.state.swapped_with);
      return e.state.condition == CameraCondition::Swapped && (one == a || one == b) && one + other == a + b;
    });
    EXPECT_TRUE(verdict.named && !verdict.wrong) << verdict.text;
  }
}

TEST(HealthFaults, DriftIsToldWhenTwiceTheCalibrationsErrorIsReached) {
  for (const double degrees : {0.0, 0.006, 0.02}) {  // 0, 0.1 and 0.33 px
    WatchedRigOptions options;
    options.sim.seed = 4;
    Calibration told = Scene(options.sim).calibration();
    for (CameraCalibration& camera : told.cameras) camera.rms_px = 0.05;
    options.calibration = told;
    options.sim.faults.bump = SimBump{3, 0, degrees * kDegree};
    WatchedRig rig(options);
    rig.run(6.0);
    if (degrees < 0.01) {
      EXPECT_TRUE(rig.events().empty()) << text_of(rig.events());
      continue;
    }
    ASSERT_EQ(rig.events().size(), 1u) << text_of(rig.events());
    EXPECT_EQ(index(rig.events()[0].event.camera), 3u);
    EXPECT_EQ(rig.events()[0].event.state.condition, CameraCondition::Drifting);
    const CameraReport report = rig.health().report().cameras[3];
    EXPECT_FALSE(report.green());
    EXPECT_GT(report.residual_px, 2.0 * report.expected_px);
  }
}

TEST(HealthFaults, ASecondFaultIsNamedToo) {
  WatchedRigOptions options;
  options.sim.seed = 6;
  options.sim.faults.bump = SimBump{0, 100, 0.3 * kDegree};
  options.sim.faults.delay = SimDelay{2, 400, 0.008};
  WatchedRig rig(options);
  rig.run(400.0 / 90.0 + 2.0);
  ASSERT_EQ(rig.events().size(), 2u) << text_of(rig.events());
  EXPECT_EQ(rig.events()[0].event.state.condition, CameraCondition::Bumped);
  EXPECT_EQ(index(rig.events()[0].event.camera), 0u);
  EXPECT_EQ(rig.events()[1].event.state.condition, CameraCondition::Late);
  EXPECT_EQ(index(rig.events()[1].event.camera), 2u);
}

}  // namespace
}  // namespace glint::testing
