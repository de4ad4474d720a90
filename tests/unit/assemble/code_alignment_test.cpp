// SPDX-License-Identifier: MIT
// What coded pulses prove, and what they must not be taken to prove.
#include "host/assemble/code_alignment.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <optional>
#include <random>
#include <string>
#include <vector>

#include "tests/support/allocations.hpp"

namespace glint {
namespace {

using Kind = AlignmentEvent::Kind;
constexpr std::size_t kCameras = 4;
constexpr double kPeriod_s = 1.0 / 90.0;

/// Four cameras that see ten markers; a hand to make them slip, go blind and lose frames.
class CodedCameras : public ::testing::Test {
 protected:
  struct Eye {
    int slip = 0;  ///< true minus corrected
    std::uint32_t blobs = 10, in_the_dark = 0;
    std::uint32_t run = 0;
    int shifted = 0;
    bool obeys = true, frame = true;
  };

  bool dark(std::uint64_t at, int slip) const {
    return code.dark(at + first - static_cast<std::uint64_t>(slip));
  }
  void step() {
    std::array<SeenLight, kCameras> seen{};
    for (std::size_t n = 0; n < kCameras; ++n) {
      Eye& eye = eyes[n];
      const int wanted = alignment.wanted_shift(CameraId{static_cast<std::uint8_t>(n)});
      if (eye.obeys && wanted != eye.shifted) {
        eye.slip += wanted - eye.shifted;
        eye.shifted = wanted;
        ++eye.run;
      }
      if (!eye.frame) continue;
      seen[n] = {true, dark(pulse, eye.slip) ? eye.in_the_dark : eye.blobs, eye.run, eye.shifted};
    }
    alignment.add(pulse, Timestamp(std::chrono::nanoseconds(static_cast<std::int64_t>(1e9 * pulse_s()))),
                  seen);
    for (const AlignmentEvent& event : alignment.events()) events.push_back(event);
    ++pulse;
  }
  double pulse_s() const { return static_cast<double>(pulse) * kPeriod_s; }
  void run(int pulses) {
    for (int n = 0; n < pulses; ++n) step();
  }
  /// Pulses until a dark one is the next.
  void run_to_dark() {
    while (!dark(pulse, 0)) step();
  }
  void start() {
    run(450);
    ASSERT_TRUE(alignment.report().phase);
    ASSERT_EQ(alignment.unproven(), 0u);
    events.clear();
  }
  std::size_t count(Kind kind) const {
    return static_cast<std::size_t>(
        std::count_if(events.begin(), events.end(), [&](const auto& event) { return event.kind == kind; }));
  }

  PulseCode code{12, 30};
  CodeAlignment alignment{code, kCameras};
  std::uint64_t first = 3'456;  // the board's number of our pulse 0
  std::uint64_t pulse = 0;
  std::array<Eye, kCameras> eyes;
  std::vector<AlignmentEvent> events;
};

TEST_F(CodedCameras, TellTheBoardsPulseNumbersWithinSeconds) {
  int pulses = 0;
  for (; !alignment.report().phase; ++pulses) {
    ASSERT_LT(pulses, 400);
    EXPECT_EQ(alignment.unproven(), 0b1111u);
    EXPECT_FALSE(alignment.dark(pulse));
    step();
  }
  EXPECT_GT(pulses, 60) << "that is luck, not certainty";
  EXPECT_EQ(*alignment.report().phase, first % code.length());
  run(60);
  EXPECT_EQ(alignment.unproven(), 0u);
  for (std::uint64_t p = pulse; p < pulse + 100; ++p) EXPECT_EQ(alignment.dark(p), dark(p, 0));
  ASSERT_EQ(events.size(), 1u);
  EXPECT_EQ(events[0].kind, Kind::PhaseFound);
}

TEST_F(CodedCameras, OneThatIsOffFromTheStartIsOutvoted) {
  eyes[2].slip = 1;
  run(450);
  EXPECT_EQ(*alignment.report().phase, first % code.length());
  ASSERT_EQ(count(Kind::SlipFound), 1u);
  EXPECT_EQ(events[1].camera, CameraId{2});
  EXPECT_EQ(events[1].pulses, 1);
  EXPECT_EQ(alignment.unproven(), 0u);
  EXPECT_EQ(alignment.wanted_shift(CameraId{2}), -1);
}

TEST_F(CodedCameras, AnIrregularStepUnprovesInThatVerySetUntilADarkPulseAgrees) {
  start();
  ++eyes[1].run;
  step();
  EXPECT_EQ(alignment.unproven(), 0b0010u);
  run_to_dark();
  EXPECT_EQ(alignment.unproven(), 0b0010u);
  run(2);  // the dark one, and one more to know that it was alone
  EXPECT_EQ(alignment.unproven(), 0u);
  EXPECT_TRUE(events.empty());
}

TEST_F(CodedCameras, ASlipOfAnySizeIsFoundAndCorrected) {
  for (int slip = -CodeAlignment::kMostSlip; slip <= CodeAlignment::kMostSlip; ++slip) {
    if (slip == 0) continue;
    SCOPED_TRACE(slip);
    events.clear();
    run(450);
    ASSERT_EQ(alignment.unproven(), 0u);
    eyes[3].slip += slip;
    ++eyes[3].run;
    int until_found = 0;
    for (; count(Kind::SlipFound) == 0 && until_found < 200; ++until_found) {
      step();
      EXPECT_NE(alignment.unproven() & 0b1000u, 0u);
    }
    EXPECT_LT(until_found, 90);
    run(100);
    EXPECT_EQ(eyes[3].slip, 0);
    EXPECT_EQ(alignment.unproven(), 0u);
    EXPECT_EQ(count(Kind::SlipFound), 1u);
    EXPECT_EQ(count(Kind::SlipCorrected), 1u);
  }
  EXPECT_EQ(alignment.report().cameras[3].slips_found, 16u);
  EXPECT_EQ(alignment.report().cameras[3].slips_corrected, 16u);
}

TEST_F(CodedCameras, ASlipThatNothingAnnouncedIsSeenAtTheNextDarkPulse) {
  start();
  eyes[0].slip = 2;
  run_to_dark();
  EXPECT_EQ(alignment.unproven(), 0u);
  run(2);
  EXPECT_EQ(alignment.unproven(), 0b0001u);
  run(100);
  EXPECT_EQ(eyes[0].slip, 0);
  EXPECT_EQ(alignment.unproven(), 0u);
}

TEST_F(CodedCameras, WhatIsStillOnItsWayIsNoEvidence) {
  start();
  eyes[1].slip = 3;
  eyes[1].obeys = false;
  ++eyes[1].run;
  run(500);
  EXPECT_EQ(count(Kind::SlipFound), 1u);
  EXPECT_EQ(alignment.wanted_shift(CameraId{1}), -3);
  EXPECT_EQ(alignment.unproven(), 0b0010u);
  eyes[1].obeys = true;
  run(60);
  EXPECT_EQ(alignment.unproven(), 0u);
  EXPECT_EQ(count(Kind::SlipCorrected), 1u);
}

TEST_F(CodedCameras, OneThatSeesNothingStaysWhatItWas) {
  eyes[3].blobs = 0;
  run(600);
  EXPECT_EQ(alignment.unproven(), 0b1000u);
  eyes[3].blobs = 4;
  eyes[2].blobs = 0;
  run(100);
  EXPECT_EQ(alignment.unproven(), 0u) << "nothing irregular happened to camera 2";
  ++eyes[2].run;
  run(500);
  EXPECT_EQ(alignment.unproven(), 0b0100u) << "and now nothing can prove it";
  EXPECT_EQ(count(Kind::SlipFound), 0u);
}

TEST_F(CodedCameras, OneMarkerIsEnough) {
  start();
  eyes[2].blobs = 1;
  ++eyes[2].run;
  run(60);
  EXPECT_EQ(alignment.unproven(), 0u);
  eyes[2].slip = -2;
  ++eyes[2].run;
  run(200);
  EXPECT_EQ(eyes[2].slip, 0);
  EXPECT_EQ(alignment.unproven(), 0u);
}

TEST_F(CodedCameras, MarkersThatAreHiddenForAWhileProveNothing) {
  start();
  std::mt19937 random(4);
  for (int n = 0; n < 3000; ++n) {
    // Two to twelve pictures of one camera without a blob, now and then.
    Eye& eye = eyes[random() % kCameras];
    const std::uint32_t before = eye.blobs;
    eye.blobs = 0;
    run(2 + static_cast<int>(random() % 11));
    eye.blobs = before;
    run(static_cast<int>(random() % 20));
  }
  EXPECT_EQ(events.size(), 0u);
}

TEST_F(CodedCameras, ASingleMarkerThatBlinksIsNoSlip) {
  start();
  std::mt19937 random(5);
  eyes[1].blobs = 1;
  for (int n = 0; n < 20'000; ++n) {
    eyes[1].blobs = random() % 20 == 0 ? 0 : 1;
    eyes[1].run += random() % 50 == 0 ? 1U : 0U;
    eyes[1].frame = random() % 50 != 0;
    step();
  }
  EXPECT_EQ(count(Kind::SlipFound), 0u);
  EXPECT_EQ(count(Kind::PhaseLost), 0u);
}

TEST_F(CodedCameras, ALampThatIsNeverOffProvesNothing) {
  start();
  eyes[1].blobs = eyes[1].in_the_dark = 3;
  ++eyes[1].run;
  std::mt19937 random(6);
  for (int n = 0; n < 20'000; ++n) {
    eyes[1].frame = random() % 50 != 0;
    step();
  }
  EXPECT_EQ(alignment.unproven(), 0b0010u);
  EXPECT_TRUE(events.empty());
}

TEST_F(CodedCameras, ALampBesideMarkersDoesNoHarm) {
  eyes[0].blobs = 5;
  eyes[0].in_the_dark = 1;
  run(450);
  EXPECT_EQ(alignment.unproven(), 0u);
}

TEST_F(CodedCameras, AnotherSeedIsNotTakenForThisOne) {
  code = PulseCode(13, 30);  // what the light does
  run(3000);
  EXPECT_FALSE(alignment.report().phase);
  EXPECT_EQ(alignment.unproven(), 0b1111u);
  EXPECT_EQ(count(Kind::NoPhase), 1u);
  EXPECT_EQ(events.size(), 1u);
}

TEST_F(CodedCameras, LightThatIsNeverOffIsNotTakenForTheCode) {
  for (Eye& eye : eyes) eye.in_the_dark = 10;
  run(3000);
  EXPECT_FALSE(alignment.report().phase);
  EXPECT_EQ(count(Kind::NoPhase), 1u);
}

TEST_F(CodedCameras, ARestartedBoardIsLookedForAnew) {
  start();
  first += 1000;
  run(900);
  EXPECT_EQ(count(Kind::PhaseLost), 1u);
  EXPECT_EQ(*alignment.report().phase, first % code.length());
  EXPECT_EQ(alignment.unproven(), 0u);
  // Pulses that are counted anew.
  events.clear();
  pulse = 0;
  step();
  EXPECT_EQ(alignment.unproven(), 0b1111u);
  run(450);
  EXPECT_EQ(alignment.unproven(), 0u);
  EXPECT_EQ(count(Kind::PhaseLost), 1u);
}

TEST_F(CodedCameras, TimeIsCounted) {
  start();
  const CameraAlignment before = alignment.report().cameras[1];
  eyes[1].obeys = false;
  eyes[1].slip = 1;
  ++eyes[1].run;
  run(900);
  const CameraAlignment& after = alignment.report().cameras[1];
  EXPECT_NEAR(after.unproven_s - before.unproven_s, 10.0, 1e-6);
  EXPECT_NEAR(after.longest_unproven_s, 10.0, 1e-6);
  EXPECT_EQ(after.proven_s, before.proven_s);
  EXPECT_GT(alignment.report().dark_pulses, 30u);
}

TEST_F(CodedCameras, AllocateNothing) {
  events.reserve(1000);
  const std::size_t before = testing::allocations();
  run(450);
  eyes[1].slip = 2;
  ++eyes[1].run;
  run(300);
  first += 777;
  run(600);
  EXPECT_EQ(testing::allocations(), before);
  EXPECT_EQ(alignment.unproven(), 0u);
}

TEST(LightHistory, SaysDarkOnlyBetweenLitPictures) {
  LightHistory light;
  const auto said = [&light](std::uint64_t pulse, std::uint32_t blobs) -> std::string {
    const std::optional<LightEvidence> evidence = light.add(pulse, blobs);
    if (!evidence) return "nothing";
    return (evidence->lit ? "lit " : "dark ") + std::to_string(evidence->pulse);
  };
  EXPECT_EQ(said(1, 8), "nothing");
  EXPECT_EQ(said(2, 8), "nothing");
  EXPECT_EQ(said(3, 0), "lit 2");
  EXPECT_EQ(said(4, 8), "dark 3");
  EXPECT_EQ(said(5, 8), "lit 4");
  EXPECT_EQ(said(6, 0), "lit 5");
  EXPECT_EQ(said(7, 0), "nothing") << "two dark ones in a row are none";
  EXPECT_EQ(said(8, 8), "nothing");
  EXPECT_EQ(said(9, 5), "lit 8");
  EXPECT_EQ(said(10, 8), "nothing") << "5 beside 8 and 8 is neither";
  EXPECT_EQ(said(12, 2), "lit 10");
  EXPECT_EQ(said(14, 9), "dark 12");
  EXPECT_EQ(said(19, 8), "nothing") << "too far away";
}

}  // namespace
}  // namespace glint
