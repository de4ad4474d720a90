// SPDX-License-Identifier: MIT
// The identity score counts what it says: made-up trackers with one known fault each.
#include "host/sim/identity_score.hpp"

#include <gtest/gtest.h>

#include <bit>
#include <cmath>
#include <functional>
#include <limits>
#include <optional>
#include <vector>

#include "host/sim/random.hpp"

namespace glint {
namespace {

using Samples = std::vector<IdentitySample>;
using Change = std::function<void(std::uint64_t tick, Samples& samples)>;

bool expected(const TickTruth& truth, std::uint32_t marker) {
  return std::popcount(truth.markers[marker].visible & truth.delivered) >= 2;
}

IdentitySample sample_of(const TickTruth& truth, std::uint32_t marker) {
  IdentitySample sample;
  sample.id = marker + 1;
  sample.position_in_world = truth.markers[marker].position_in_world;
  sample.cameras = truth.markers[marker].visible & truth.delivered;
  return sample;
}

/// What a perfect tracker gives: marker m has id m + 1.
Samples perfect(const Scene& scene, std::uint64_t tick) {
  TickTruth truth;
  scene.truth(tick, truth);
  Samples samples;
  for (std::uint32_t m = 0; m < scene.markers(); ++m)
    if (expected(truth, m)) samples.push_back(sample_of(truth, m));
  return samples;
}

IdentityResult score(const Scene& scene, std::uint64_t ticks, const Change& change,
                     const IdentityOptions& options = {}) {
  IdentityScore score(scene, options);
  for (std::uint64_t tick = 0; tick < ticks; ++tick) {
    Samples samples = perfect(scene, tick);
    change(tick, samples);
    score.add(tick, samples);
  }
  return score.result();
}

IdentitySample* with_id(Samples& samples, std::uint32_t id) {
  for (IdentitySample& sample : samples)
    if (sample.id == id) return &sample;
  return nullptr;
}

/// Two markers that are expected, and near no other, in all of the first `ticks`.
std::vector<std::uint32_t> lasting_markers(const Scene& scene, std::uint64_t ticks) {
  std::vector<std::uint32_t> found;
  for (std::uint32_t m = 0; m < scene.markers(); ++m) {
    bool lasting = true;
    TickTruth truth;
    for (std::uint64_t tick = 0; lasting && tick < ticks; ++tick) {
      scene.truth(tick, truth);
      lasting = expected(truth, m);
    }
    if (lasting) found.push_back(m);
  }
  return found;
}

constexpr std::uint64_t kTicks = 60;

class IdentityScoreTest : public testing::Test {
 protected:
  IdentityScoreTest() : scene_({}) {
    const std::vector<std::uint32_t> lasting = lasting_markers(scene_, kTicks);
    EXPECT_GE(lasting.size(), 2u);
    a_ = lasting.at(0) + 1;
    b_ = lasting.at(1) + 1;
  }
  void exchange(Samples& samples) const {
    IdentitySample *const a = with_id(samples, a_), *const b = with_id(samples, b_);
    std::swap(a->id, b->id);
  }

  Scene scene_;
  std::uint32_t a_ = 0, b_ = 0;  // ids
};

TEST_F(IdentityScoreTest, ThePerfectTrackerIsPerfect) {
  const IdentityResult result = score(scene_, kTicks, [](std::uint64_t, Samples&) {});
  EXPECT_EQ(result.ticks, kTicks);
  EXPECT_GT(result.expected, kTicks * 10);
  EXPECT_EQ(result.found, result.expected);
  EXPECT_EQ(result.recall, 1.0);
  EXPECT_EQ(result.ghosts + result.doubled + result.mixed, 0u);
  EXPECT_EQ(result.mixed_checked, result.measured);
  EXPECT_EQ(result.ids.fragments + result.ids.swaps + result.ids.silent_swaps + result.ids.returns, 0u);
  EXPECT_EQ(result.longest_gap_frames, 0u);
  EXPECT_EQ(result.rms_m + result.worst_m + result.ambiguous_share + result.predicted_share, 0.0);
  EXPECT_EQ(result.nees.samples, 0u);
  EXPECT_EQ(result.nees_outside(), 0.0);
  EXPECT_EQ(result.cameras_back, 0u);
}

TEST_F(IdentityScoreTest, AnExchangeIsTwoSilentSwaps) {
  const IdentityResult result = score(scene_, kTicks, [&](std::uint64_t tick, Samples& samples) {
    if (tick >= 20) exchange(samples);
  });
  EXPECT_EQ(result.ids.swaps, 2u);
  EXPECT_EQ(result.ids.silent_swaps, 2u);
  EXPECT_EQ(result.ids.fragments, 0u);
  EXPECT_EQ(result.ids.returns, 0u);
  EXPECT_EQ(result.recall, 1.0);
  EXPECT_EQ(result.rms_m, 0.0);
}

/// Exchanges at tick 20 and marks one id ambiguous at one tick.
IdentityResult announced_at(const Scene& scene, std::uint64_t marked_tick, std::uint32_t a, std::uint32_t b) {
  return score(scene, kTicks, [&](std::uint64_t tick, Samples& samples) {
    IdentitySample *const first = with_id(samples, a), *const second = with_id(samples, b);
    if (tick >= 20) std::swap(first->id, second->id);
    if (tick == marked_tick) with_id(samples, a)->ambiguous = true;
  });
}

TEST_F(IdentityScoreTest, ASwapIsAnnouncedFromItsLastSampleBeforeToItsFirstAfter) {
  EXPECT_EQ(announced_at(scene_, 18, a_, b_).ids.silent_swaps, 2u);
  EXPECT_EQ(announced_at(scene_, 19, a_, b_).ids.silent_swaps, 1u);
  EXPECT_EQ(announced_at(scene_, 20, a_, b_).ids.silent_swaps, 1u);
  EXPECT_EQ(announced_at(scene_, 21, a_, b_).ids.silent_swaps, 2u);
  EXPECT_EQ(announced_at(scene_, 20, a_, b_).ids.swaps, 2u);
  EXPECT_GT(announced_at(scene_, 20, a_, b_).ambiguous_share, 0.0);
}

TEST_F(IdentityScoreTest, APredictionOnTheWayMayAnnounceASwap) {
  const auto run = [&](bool marked) {
    return score(scene_, kTicks, [&](std::uint64_t tick, Samples& samples) {
      if (tick >= 20) exchange(samples);
      if (tick < 18 || tick >= 22) return;
      for (const std::uint32_t id : {a_, b_}) {
        with_id(samples, id)->predicted = true;
        with_id(samples, id)->ambiguous = marked && tick == 19;
      }
    });
  };
  EXPECT_EQ(run(false).ids.silent_swaps, 2u);
  EXPECT_EQ(run(true).ids.silent_swaps, 0u);
  EXPECT_EQ(run(true).ids.swaps, 2u);
}

TEST_F(IdentityScoreTest, FragmentsAndReturns) {
  const IdentityResult result = score(scene_, kTicks, [&](std::uint64_t tick, Samples& samples) {
    if (tick >= 20 && tick < 30) with_id(samples, a_)->id = 1000;
  });
  EXPECT_EQ(result.ids.fragments, 1u);
  EXPECT_EQ(result.ids.returns, 1u);
  EXPECT_EQ(result.ids.swaps, 0u);
}

TEST_F(IdentityScoreTest, WhereSeveralMarkersAreNearIdsAreNotRead) {
  IdentityOptions wide;
  wide.gate_m = 20.0;  // the whole room
  const IdentityResult result = score(
      scene_, kTicks,
      [&](std::uint64_t tick, Samples& samples) {
        if (tick >= 20) exchange(samples);
      },
      wide);
  EXPECT_EQ(result.ids.swaps, 0u);
  EXPECT_EQ(result.rms_m, 0.0);  // the assignment is by position nevertheless
}

TEST_F(IdentityScoreTest, GhostsAndDoubles) {
  const IdentityResult result = score(scene_, 2, [&](std::uint64_t tick, Samples& samples) {
    if (tick == 0) return;
    IdentitySample extra;
    extra.id = 78;
    extra.position_in_world = samples[0].position_in_world + Eigen::Vector3d(0, 0, 0.005);
    samples.push_back(extra);
    extra.position_in_world = {5, 5, 5};
    samples.push_back(extra);
    extra.position_in_world.setConstant(std::nan(""));
    samples.push_back(extra);
  });
  EXPECT_EQ(result.doubled, 1u);
  EXPECT_EQ(result.doubled_per_tick, 0.5);
  EXPECT_EQ(result.ghosts, 2u);
  EXPECT_EQ(result.ghosts_per_tick, 1.0);
  EXPECT_EQ(result.mixed, 0u);
  EXPECT_EQ(result.rms_m, 0.0);
}

/// A point that cameras 0 and 1 see where two different markers are, far from any marker.
std::optional<IdentitySample> mixed_sample(const Scene& scene, std::uint64_t tick) {
  TickTruth truth;
  scene.truth(tick, truth);
  const Eigen::Vector3d from = scene.camera(0, tick).position_in_world();
  const Eigen::Vector3d other = scene.camera(1, tick).position_in_world();
  for (std::uint32_t a = 0; a < scene.markers(); ++a) {
    for (std::uint32_t b = 0; b < scene.markers(); ++b) {
      if (a == b || (truth.markers[a].visible & 1u) == 0 || (truth.markers[b].visible & 2u) == 0) continue;
      const Eigen::Vector3d along = (truth.markers[a].position_in_world - from).normalized();
      const Eigen::Vector3d beside = (truth.markers[b].position_in_world - other).normalized();
      const Eigen::Vector3d normal = along.cross(beside);
      if (std::abs((other - from).dot(normal.normalized())) > 0.002) continue;
      const double depth_m = (other - from).cross(beside).dot(normal) / normal.squaredNorm();
      IdentitySample sample;
      sample.id = 500;
      sample.cameras = 3;
      sample.position_in_world = from + depth_m * along;
      bool far = depth_m > 0.5;
      for (const MarkerTruth& marker : truth.markers)
        far = far && (marker.position_in_world - sample.position_in_world).norm() > 0.1;
      if (far) return sample;
    }
  }
  return std::nullopt;
}

TEST_F(IdentityScoreTest, APointMadeOfTwoMarkersImagesIsMixed) {
  std::uint64_t made = 0;
  const IdentityResult result = score(scene_, kTicks, [&](std::uint64_t tick, Samples& samples) {
    std::optional<IdentitySample> sample = mixed_sample(scene_, tick);
    if (!sample) return;
    ++made;
    samples.push_back(*sample);
    sample->cameras = 1;  // one camera alone mixes nothing
    samples.push_back(*sample);
    sample->cameras = 0;  // and who does not say is not judged
    samples.push_back(*sample);
  });
  EXPECT_GE(made, 2u);
  EXPECT_EQ(result.mixed, made);
  EXPECT_EQ(result.ghosts, 3 * made);
  EXPECT_EQ(result.mixed_checked, result.measured - made);
}

TEST_F(IdentityScoreTest, AGapIsCountedInExpectedFrames) {
  const IdentityResult result = score(scene_, kTicks, [&](std::uint64_t tick, Samples& samples) {
    IdentitySample& sample = *with_id(samples, a_);
    if (tick >= 10 && tick < 13) samples.erase(samples.begin() + (&sample - samples.data()));
    if (tick >= 20 && tick < 25) sample.predicted = true;  // does not fill the gap
  });
  EXPECT_EQ(result.longest_gap_frames, 5u);
  EXPECT_EQ(result.expected - result.found, 8u);
  EXPECT_EQ(result.predicted, 5u);
  EXPECT_EQ(result.ghosts, 0u);
  EXPECT_EQ(result.ids.swaps + result.ids.fragments + result.ids.returns, 0u);
}

TEST_F(IdentityScoreTest, PredictionsAreComparedWithTheMarkerOfTheirId) {
  const IdentityResult result = score(scene_, kTicks, [&](std::uint64_t tick, Samples& samples) {
    IdentitySample& sample = *with_id(samples, a_);
    if (tick >= 20 && tick < 30) {
      sample.predicted = true;
      sample.position_in_world.x() += tick < 25 ? 0.03 : 0.04;  // beyond the gate
    }
    IdentitySample stray;
    stray.id = 900;
    stray.predicted = true;
    if (tick == 3) samples.push_back(stray);
  });
  EXPECT_EQ(result.predicted, 11u);
  EXPECT_EQ(result.predicted_of_nothing, 1u);
  EXPECT_NEAR(result.predicted_rms_m, std::sqrt((0.03 * 0.03 + 0.04 * 0.04) / 2.0), 1e-12);
  EXPECT_NEAR(result.predicted_worst_m, 0.04, 1e-12);
  EXPECT_EQ(result.rms_m, 0.0);
}

TEST_F(IdentityScoreTest, ErrorsAsGiven) {
  const IdentityResult result = score(scene_, kTicks, [&](std::uint64_t tick, Samples& samples) {
    for (IdentitySample& sample : samples) sample.position_in_world.y() += 1e-4;
    if (tick == 7) with_id(samples, a_)->position_in_world.y() += 4.9e-3;
  });
  EXPECT_NEAR(result.worst_m, 5e-3, 1e-12);
  EXPECT_NEAR(result.median_m, 1e-4, 1e-6);
  EXPECT_NEAR(result.q999_m, 1e-4, 1e-6);
  const auto n = static_cast<double>(result.measured);
  EXPECT_NEAR(result.rms_m, std::sqrt(((n - 1.0) * 1e-8 + 25e-6) / n), 1e-12);
}

/// Normal errors of 0.1 mm per axis that stay for `hold` ticks, under a covariance `claimed` times the true
/// one.
IdentityResult noisy(const Scene& scene, std::uint64_t hold, double claimed) {
  const sim::NormalTable normal;
  return score(scene, 270, [&](std::uint64_t tick, Samples& samples) {
    for (IdentitySample& sample : samples) {
      sim::Random random(sim::mix(sim::mix(sample.id) ^ (tick / hold)));
      for (int axis = 0; axis < 3; ++axis)
        sample.position_in_world[axis] += 1e-4 * static_cast<double>(normal.draw(random));
      sample.covariance_m2 = Eigen::Matrix3d::Identity() * (1e-8 * claimed);
    }
  });
}

TEST_F(IdentityScoreTest, HonestCovariancesHaveOneInTheBandAndOthersDoNot) {
  const IdentityResult honest = noisy(scene_, 1, 1.0);
  EXPECT_EQ(honest.nees.samples, honest.measured);
  EXPECT_EQ(honest.nees_outside(), 0.0);
  EXPECT_NEAR(honest.nees.mean, 1.0, 0.05);
  EXPECT_LT(honest.nees.high - honest.nees.low, 0.1);
  const IdentityResult too_sure = noisy(scene_, 1, 0.25);
  EXPECT_NEAR(too_sure.nees.mean, 4.0, 0.2);
  EXPECT_GT(too_sure.nees_outside(), 2.5);
  EXPECT_GT(noisy(scene_, 1, 4.0).nees_outside(), 0.6);
}

TEST_F(IdentityScoreTest, ErrorsThatLastWidenTheBand) {
  const IdentityResult quick = noisy(scene_, 1, 1.0), lasting = noisy(scene_, 90, 1.0);
  EXPECT_GT(lasting.nees.high - lasting.nees.low, 4.0 * (quick.nees.high - quick.nees.low));
  EXPECT_EQ(lasting.nees_outside(), 0.0);
}

TEST_F(IdentityScoreTest, ACovarianceThatIsNoneIsAFault) {
  const IdentityResult result = score(scene_, kTicks, [&](std::uint64_t tick, Samples& samples) {
    for (IdentitySample& sample : samples) sample.covariance_m2.setIdentity();
    Eigen::Matrix3d& wrong = with_id(samples, a_)->covariance_m2;
    if (tick == 5) wrong(0, 0) = -1.0;
    if (tick == 6) wrong(1, 1) = std::nan("");
  });
  EXPECT_EQ(result.covariance_faults, 2u);
  EXPECT_EQ(result.nees_outside(), std::numeric_limits<double>::infinity());
}

TEST(IdentityScoreFaults, RecoveryAfterACameraComesBack) {
  SimOptions options;
  options.faults.off.push_back({1, 20, 20});
  const Scene scene(options);
  const IdentityResult prompt = score(scene, kTicks, [](std::uint64_t, Samples&) {});
  EXPECT_EQ(prompt.cameras_back, 1u);
  EXPECT_EQ(prompt.recovery_frames, 0u);
  const IdentityResult slow = score(scene, kTicks, [](std::uint64_t tick, Samples& samples) {
    if (tick >= 40 && tick < 43) samples.pop_back();
    if (tick == 45) samples.pop_back();  // complete since: another matter
  });
  EXPECT_EQ(slow.cameras_back, 1u);
  EXPECT_EQ(slow.recovery_frames, 3u);
}

TEST(IdentityScoreRod, TheDistanceOfTwoMarkersIsScored) {
  SimOptions options;
  options.motion = SimMotion::Wand;
  options.wand_m = {0.0, 0.589};
  options.markers = 2;
  const Scene scene(options);
  const IdentityResult result = score(scene, kTicks, [&](std::uint64_t, Samples& samples) {
    if (samples.size() < 2) return;
    const Eigen::Vector3d rod = samples[1].position_in_world - samples[0].position_in_world;
    samples[1].position_in_world += 1e-3 * rod.normalized();
  });
  EXPECT_GT(result.pairs, kTicks / 2);
  EXPECT_NEAR(result.pair_rms_m, 1e-3, 1e-9);
  EXPECT_NEAR(result.pair_worst_m, 1e-3, 1e-9);
}

}  // namespace
}  // namespace glint
