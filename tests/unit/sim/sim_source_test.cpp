// SPDX-License-Identifier: MIT
// The simulated rig as a source: times, sequence numbers, faults.
#include "host/sim/sim_source.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <optional>
#include <vector>

#include "host/base/pulse_code.hpp"
#include "host/sim/faults.hpp"

namespace glint {
namespace {

SimOptions small() {
  SimOptions options;
  options.width_px = 320;
  options.height_px = 200;
  options.markers = 10;
  return options;
}

FramePool pool_for(const Scene& scene, std::uint32_t slots) {
  return FramePool(
      std::vector<FrameSize>(scene.cameras(), {scene.options().width_px, scene.options().height_px}), slots);
}

std::vector<std::uint8_t> pixels_of(const Frame& frame) {
  const gpu::ImageView view = frame.image();
  std::vector<std::uint8_t> pixels;
  for (std::uint32_t y = 0; y < view.height_px; ++y) {
    pixels.insert(pixels.end(), view.pixels + std::size_t{y} * view.stride_bytes,
                  view.pixels + std::size_t{y} * view.stride_bytes + view.width_px);
  }
  return pixels;
}

TEST(SimSource, NamesSizesAndTimes) {
  const Scene scene(small());
  SimSource source(scene, {true, 3});
  const Timestamp start{std::chrono::seconds(1000)};
  source.set_start(start);
  ASSERT_EQ(source.cameras().size(), 4u);
  EXPECT_EQ(source.cameras()[3].name, "cam4");
  EXPECT_EQ(source.cameras()[0].size.width_px, 320u);
  EXPECT_EQ(source.rate_hz(), 90.0);
  EXPECT_TRUE(source.live());
  FramePool pool = pool_for(scene, 2);
  FrameSet set;
  for (std::uint64_t tick = 0; tick < 3; ++tick) {
    ASSERT_EQ(source.read(pool, set), ReadStatus::Ok);
    EXPECT_EQ(number(set.trigger), tick);
    EXPECT_NEAR(seconds_between(start, set.exposed), static_cast<double>(tick) / 90.0, 1e-9);
    for (std::size_t c = 0; c < 4; ++c) {
      ASSERT_TRUE(set.frames[c].has_value());
      EXPECT_EQ(index(set.frames[c]->camera), c);
      EXPECT_EQ(set.frames[c]->sequence, tick);
      EXPECT_NEAR(seconds_between(set.frames[c]->stamped, set.exposed), 137e-6 / 2, 1e-8);
    }
  }
  EXPECT_EQ(source.read(pool, set), ReadStatus::End);
  EXPECT_FALSE(set.frames[0].has_value());
  EXPECT_EQ(source.counters().frames, 12u);
  EXPECT_EQ(source.problem(), "");
}

TEST(SimSource, ImagesDoNotDependOnThePool) {
  const Scene scene(small());
  SimSource one(scene), other(scene);
  FramePool two_slots = pool_for(scene, 2), five_slots = pool_for(scene, 5);
  FrameSet set;
  std::vector<FrameSet> held(4);
  for (std::size_t tick = 0; tick < 40; ++tick) {
    ASSERT_EQ(one.read(two_slots, set), ReadStatus::Ok);
    ASSERT_EQ(other.read(five_slots, held[tick % held.size()]), ReadStatus::Ok);
    for (std::size_t c = 0; c < 4; ++c) {
      ASSERT_EQ(pixels_of(*set.frames[c]), pixels_of(*held[tick % held.size()].frames[c])) << "tick " << tick;
    }
  }
}

TEST(SimSource, ANewPoolAtAnOldAddressIsDrawnWhole) {
  const Scene scene(small());
  SimSource source(scene), reference(scene);
  FramePool lasting = pool_for(scene, 1);
  FrameSet set, expected;
  for (int i = 0; i < 4; ++i) {
    FramePool pool = pool_for(scene, 1);
    for (int tick = 0; tick < 2; ++tick) {
      ASSERT_EQ(source.read(pool, set), ReadStatus::Ok);
      ASSERT_EQ(reference.read(lasting, expected), ReadStatus::Ok);
      EXPECT_EQ(pixels_of(*set.frames[0]), pixels_of(*expected.frames[0]));
    }
    set = {};
  }
}

TEST(SimSource, FaultsAreAppliedAndCountedAsTheTruthSays) {
  SimOptions options = small();
  options.faults.drop_rate = 0.1;
  options.faults.late_rate = 0.1;
  options.faults.late_s = 0.02;
  options.faults.duplicate_rate = 0.1;
  const Scene scene(options);
  SimSource source(scene);
  FramePool pool = pool_for(scene, 2);
  FrameSet set;
  TickTruth truth;
  std::uint64_t missing = 0, late = 0, duplicated = 0;
  std::vector<std::uint8_t> before;
  constexpr std::uint64_t kTicks = 500;
  for (std::uint64_t tick = 0; tick < kTicks; ++tick) {
    ASSERT_EQ(source.read(pool, set), ReadStatus::Ok);
    scene.truth(tick, truth);
    for (std::uint32_t c = 0; c < 4; ++c) {
      const sim::Fate fate = sim::fate(options, c, tick);
      EXPECT_EQ((truth.delivered >> c & 1u) == 1u, fate == sim::Fate::Fine);
      const bool there = fate == sim::Fate::Fine || fate == sim::Fate::Duplicated;
      ASSERT_EQ(set.frames[c].has_value(), there);
      missing += there ? 0u : 1u;
      late += fate == sim::Fate::Late ? 1u : 0u;
      if (!there) continue;
      EXPECT_EQ(set.frames[c]->sequence, fate == sim::Fate::Duplicated ? tick - 1 : tick);
      if (fate == sim::Fate::Duplicated) {
        ++duplicated;
        if (c == 0) {
          EXPECT_EQ(pixels_of(*set.frames[0]), before);
        }
      }
      if (c == 0) before = pixels_of(*set.frames[0]);
    }
  }
  const SourceCounters counted = source.counters();
  EXPECT_EQ(counted.missing, missing);
  EXPECT_EQ(counted.late, late);
  EXPECT_EQ(counted.duplicated, duplicated);
  EXPECT_EQ(counted.frames + counted.missing, 4 * kTicks);
  // 2000 draws each of about a tenth.
  EXPECT_NEAR(static_cast<double>(late), 180.0, 50.0);
  EXPECT_NEAR(static_cast<double>(missing - late), 200.0, 50.0);
  EXPECT_NEAR(static_cast<double>(duplicated), 130.0, 50.0);
}

TEST(SimSource, ALittleLateIsInTime) {
  SimOptions options = small();
  options.faults.late_rate = 1.0;
  options.faults.late_s = 0.002;
  const Scene scene(options);
  SimSource source(scene);
  FramePool pool = pool_for(scene, 1);
  FrameSet set;
  ASSERT_EQ(source.read(pool, set), ReadStatus::Ok);
  EXPECT_TRUE(set.frames[0].has_value());
}

TEST(SimSource, AnExhaustedPoolIsCountedAndNoCrash) {
  const Scene scene(small());
  SimSource source(scene);
  FramePool pool = pool_for(scene, 1);
  FrameSet held, starved;
  ASSERT_EQ(source.read(pool, held), ReadStatus::Ok);
  ASSERT_EQ(source.read(pool, starved), ReadStatus::Ok);
  EXPECT_FALSE(starved.frames[0].has_value());
  EXPECT_EQ(source.counters().no_slot, 4u);
}

TEST(SimSource, JpegChangesTheImageALittle) {
  SimOptions options = small();
  const Scene plain_scene(options);
  options.jpeg_quality = 90;
  const Scene jpeg_scene(options);
  SimSource plain(plain_scene), jpeg(jpeg_scene);
  FramePool pool = pool_for(plain_scene, 2);
  FrameSet a, b;
  for (int tick = 0; tick < 3; ++tick) {
    ASSERT_EQ(plain.read(pool, a), ReadStatus::Ok);
    ASSERT_EQ(jpeg.read(pool, b), ReadStatus::Ok);
    const std::vector<std::uint8_t> before = pixels_of(*a.frames[0]), after = pixels_of(*b.frames[0]);
    double difference = 0.0;
    for (std::size_t i = 0; i < before.size(); ++i) difference += std::abs(before[i] - after[i]);
    difference /= static_cast<double>(before.size());
    EXPECT_GT(difference, 0.0);
    EXPECT_LT(difference, 3.0);
  }
}

TEST(SimSource, OneAndThirtyTwoCameras) {
  for (const std::uint32_t cameras : {1u, 32u}) {
    SimOptions options = small();
    options.cameras = cameras;
    const Scene scene(options);
    SimSource source(scene);
    FramePool pool = pool_for(scene, 1);
    FrameSet set;
    ASSERT_EQ(source.read(pool, set), ReadStatus::Ok);
    EXPECT_EQ(source.counters().frames, cameras);
  }
}

/// Pixels that markers light up: without them the picture is the same, noise included.
std::uint64_t light_of(const Frame& frame, const Frame& without) {
  const std::vector<std::uint8_t> with = pixels_of(frame), dark = pixels_of(without);
  std::uint64_t light = 0;
  for (std::size_t n = 0; n < with.size(); ++n) light += with[n] > dark[n] + 8 ? 1U : 0U;
  return light;
}

TEST(SimSource, CodedPulsesLeaveTheMarkersBlack) {
  SimOptions options = small();
  options.code_seed = 7;
  options.code_first = 1000;
  const Scene scene(options);
  SimOptions empty = small();
  empty.markers = 0;
  const Scene nothing(empty);
  const PulseCode code(7, PulseCode::recommended_group(options.rate_hz));
  SimSource source(scene), background(nothing);
  FramePool pool = pool_for(scene, 1), other = pool_for(nothing, 1);
  FrameSet set, without;
  TickTruth truth;
  unsigned dark = 0;
  for (std::uint64_t tick = 0; tick < 90; ++tick) {
    ASSERT_EQ(source.read(pool, set), ReadStatus::Ok);
    ASSERT_EQ(background.read(other, without), ReadStatus::Ok);
    EXPECT_EQ(scene.dark(tick), code.dark(1000 + tick));
    std::uint64_t light = 0;
    for (std::size_t c = 0; c < 4; ++c) light += light_of(*set.frames[c], *without.frames[c]);
    EXPECT_EQ(light == 0, scene.dark(tick)) << tick;
    dark += scene.dark(tick) ? 1U : 0U;
    scene.truth(tick, truth);
    std::uint32_t seen = 0;
    for (const MarkerTruth& marker : truth.markers) seen |= marker.visible | marker.clean;
    EXPECT_EQ(seen == 0, scene.dark(tick));
  }
  EXPECT_EQ(dark, 3u);
}

TEST(SimSource, ASlippedCameraShowsEarlierExposuresUntilItIsShifted) {
  SimOptions options = small();
  options.faults.slip = SimSlip{1, 10, 3};
  const Scene scene(options), straight(small());
  SimSource source(scene), truth(straight);
  FramePool pool = pool_for(scene, 1), other = pool_for(straight, 1);
  FrameSet set, expected;
  std::vector<std::vector<std::uint8_t>> exposures;
  std::uint32_t run = 0;
  for (std::uint64_t tick = 0; tick < 30; ++tick) {
    if (tick == 20) source.shift(CameraId{1}, -3);
    ASSERT_EQ(source.read(pool, set), ReadStatus::Ok);
    ASSERT_EQ(truth.read(other, expected), ReadStatus::Ok);
    exposures.push_back(pixels_of(*expected.frames[1]));
    const std::uint64_t shown = tick < 10 || tick >= 20 ? tick : tick - 3;
    EXPECT_EQ(pixels_of(*set.frames[1]), exposures[shown]) << tick;
    EXPECT_EQ(pixels_of(*set.frames[0]), pixels_of(*expected.frames[0]));
    EXPECT_EQ(set.frames[1]->shifted, tick < 20 ? 0 : -3);
    if (tick == 0) run = set.frames[1]->run;
    EXPECT_EQ(set.frames[1]->run == run, tick < 10);
    EXPECT_EQ(set.frames[0]->run, 0u);
  }
}

TEST(SimSource, SwappedAndDelayedCamerasShowWhatTheyWould) {
  SimOptions options = small();
  options.markers = 40;
  const Scene straight(options);
  options.faults.swap = SimSwap{0, 2, 10};
  options.faults.delay = SimDelay{1, 15, 3.0 / options.rate_hz};
  const Scene scene(options);
  SimSource source(scene);
  sim::Renderer renderer(straight);
  FramePool pool = pool_for(scene, 2);
  FrameSet set;
  double bright = 0.0, lit = 0.0;
  for (std::uint64_t tick = 0; tick < 25; ++tick) {
    ASSERT_EQ(source.read(pool, set), ReadStatus::Ok);
    for (std::uint32_t c = 0; c < 4; ++c) {
      const bool delayed = c == 1 && tick >= 15;
      const std::uint32_t camera = tick < 10 || c % 2 == 1 ? c : 2 - c;
      // Where markers are is exact; the noise is another one, since it goes by name and tick.
      const std::vector<float> light = renderer.light(camera, delayed ? tick + 3 : tick);
      const std::vector<std::uint8_t> pixels = pixels_of(*set.frames[c]);
      for (std::size_t n = 0; n < pixels.size(); ++n) {
        if (light[n] < 40.0f) continue;
        ++bright;
        lit += pixels[n] > 35 ? 1.0 : 0.0;
      }
      // The backdrop moves with the camera: its spots are where the straight rig's are.
      const auto spots = straight.spots(camera);
      for (const sim::BrightSpot& spot : spots) {
        const std::size_t at = static_cast<std::size_t>(std::lround(spot.y_px)) * 320 +
                               static_cast<std::size_t>(std::lround(spot.x_px));
        EXPECT_GT(pixels[at], 30) << "camera " << c << ", tick " << tick;
      }
      EXPECT_EQ(set.frames[c]->sequence, tick);
      EXPECT_NEAR(seconds_between(set.frames[c]->stamped, set.exposed), 137e-6 / 2, 1e-8);
    }
  }
  EXPECT_GT(bright, 500.0);
  EXPECT_GT(lit, 0.99 * bright);
}

}  // namespace
}  // namespace glint
