// SPDX-License-Identifier: MIT
// Lenses from made-up corners: truth found, deviations honest, outliers named, bad sessions refused.
#include "host/calibrate/intrinsics.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <numbers>
#include <random>

#include <gtest/gtest.h>

#include "host/base/error.hpp"
#include "host/sim/board_poses.hpp"
#include "host/sim/rig.hpp"
#include "host/target/board.hpp"

namespace glint {
namespace {

CameraCalibration lens(std::uint64_t seed, bool k3) {
  SimOptions options;
  options.seed = seed;
  CameraCalibration camera = sim_calibration(options).cameras[0];
  camera.world_from_camera = Pose{};
  if (!k3) camera.k1_k2_p1_p2_k3[4] = 0.0;
  return camera;
}

const BoardSpec& board() {
  static const BoardSpec spec = parse_board("chessboard:9x6:25mm");
  return spec;
}

/// The corners of each pose, with noise; the session of one camera.
SampleSet seen(const CameraCalibration& camera, const std::vector<Pose>& poses, double sigma_px,
               std::uint64_t seed) {
  std::mt19937_64 random(seed);
  std::normal_distribution<double> noise(0.0, sigma_px > 0.0 ? sigma_px : 1.0);
  SampleSet samples;
  samples.target = board_target(board());
  samples.cameras.push_back({camera.name, camera.width_px, camera.height_px});
  const Camera model(camera);
  for (std::size_t n = 0; n < poses.size(); ++n) {
    for (std::uint32_t p = 0; p < samples.target.points_in_target.size(); ++p) {
      Eigen::Vector2d pixel = model.project(poses[n] * samples.target.points_in_target[p]).value();
      if (sigma_px > 0.0) pixel += Eigen::Vector2d(noise(random), noise(random));
      samples.sightings.push_back({100 + n, 0, p, pixel});
    }
  }
  return samples;
}

std::vector<Pose> session(const CameraCalibration& camera, std::size_t views, std::uint64_t seed) {
  return sim::board_poses(camera, board_pattern(board()).squares, views, seed);
}

/// Upright before the camera at several places, all turned alike.
std::vector<Pose> parallel(std::size_t views) {
  std::vector<Pose> poses;
  for (std::size_t n = 0; n < views; ++n) {
    const double shift = static_cast<double>(n) - 0.5 * static_cast<double>(views);
    poses.push_back({Eigen::Quaterniond::Identity(),
                     {-0.1 + 0.02 * shift, -0.06 + 0.01 * shift, 0.4 + 0.02 * static_cast<double>(n)}});
  }
  return poses;
}

std::array<double, 9> parameters_of(const CameraCalibration& c) {
  const auto& k = c.k1_k2_p1_p2_k3;
  return {c.fx_px, c.fy_px, c.cx_px, c.cy_px, k[0], k[1], k[2], k[3], k[4]};
}

std::string refusal(const SampleSet& samples, const IntrinsicsOptions& options = {}) {
  try {
    calibrate_intrinsics(samples, 0, options);
  } catch (const Error& e) {
    return e.what();
  }
  return "";
}

TEST(Intrinsics, FindsTheLensExactlyWithoutNoise) {
  for (const bool k3 : {false, true}) {
    const CameraCalibration truth = lens(1, k3);
    const IntrinsicsResult result =
        calibrate_intrinsics(seen(truth, session(truth, 12, 1), 0.0, 1), 0, {.k3 = k3});
    const auto found = parameters_of(result.camera), is = parameters_of(truth);
    for (std::size_t i = 0; i < 9; ++i)
      EXPECT_NEAR(found[i], is[i], i < 4 ? 1e-3 : 1e-5) << "parameter " << i;
    EXPECT_LT(result.rms_px, 1e-4);
    EXPECT_EQ(result.camera.name, "cam1");
  }
}

TEST(Intrinsics, ErrorsAreAsLargeAsTheDeviationsSay) {
  constexpr int kRuns = 60;
  constexpr double kSigma_px = 0.1;
  std::array<double, 9> squares{};
  double sigma = 0.0, held_out = 0.0, rms = 0.0;
  int beyond_three = 0;
  for (int run = 0; run < kRuns; ++run) {
    const auto seed = static_cast<std::uint64_t>(run + 1);
    const CameraCalibration truth = lens(seed, true);
    const IntrinsicsResult result =
        calibrate_intrinsics(seen(truth, session(truth, 15, seed), kSigma_px, seed), 0, {.k3 = true});
    const auto found = parameters_of(result.camera), is = parameters_of(truth);
    for (std::size_t i = 0; i < 9; ++i) {
      ASSERT_GT(result.camera.intrinsics_sd[i], 0.0) << i;
      const double off = (found[i] - is[i]) / result.camera.intrinsics_sd[i];
      squares[i] += off * off;
      beyond_three += std::abs(off) > 3.0;
    }
    sigma += result.sigma_px / kRuns;
    rms += result.rms_px / kRuns;
    held_out += result.held_out_rms_px / kRuns;
  }
  std::printf("sigma %.4f of %.2f px, rms %.4f, held out %.4f px; error in sd:", sigma, kSigma_px, rms,
              held_out);
  for (std::size_t i = 0; i < 9; ++i) std::printf(" %.2f", std::sqrt(squares[i] / kRuns));
  std::printf("; %d of %d beyond 3 sd\n", beyond_three, 9 * kRuns);
  EXPECT_NEAR(sigma, kSigma_px, 0.02 * kSigma_px);
  // Of 60 numbers of a normal distribution the rms is within 1 +- 0.28 three times out of a thousand not.
  for (std::size_t i = 0; i < 9; ++i)
    EXPECT_NEAR(std::sqrt(squares[i] / kRuns), 1.0, 0.28) << "parameter " << i;
  EXPECT_LE(beyond_three, 6);  // 1.5 expected
  EXPECT_NEAR(held_out / rms, 1.0, 0.1);
}

TEST(Intrinsics, SpoiltViewsAreNamedAndLeftOut) {
  const CameraCalibration truth = lens(3, false);
  SampleSet samples = seen(truth, session(truth, 20, 3), 0.1, 3);
  std::mt19937_64 random(4);
  std::normal_distribution<double> shake(0.0, 3.0);
  for (Sighting& s : samples.sightings)
    if (s.tick == 104 || s.tick == 111) s.pixel += Eigen::Vector2d(shake(random), shake(random));
  const IntrinsicsResult result = calibrate_intrinsics(samples, 0, {});
  std::vector<std::uint64_t> left_out;
  for (const BoardViewResult& view : result.views)
    if (view.outlier) left_out.push_back(view.tick);
  EXPECT_EQ(left_out, (std::vector<std::uint64_t>{104, 111}));
  EXPECT_NEAR(result.sigma_px, 0.1, 0.005);
  EXPECT_NEAR(result.camera.fx_px, truth.fx_px, 4.0 * result.camera.intrinsics_sd[0]);
}

TEST(Intrinsics, SingleWrongCornersDoLittle) {
  const CameraCalibration truth = lens(5, false);
  SampleSet samples = seen(truth, session(truth, 20, 5), 0.1, 5);
  const IntrinsicsResult clean = calibrate_intrinsics(samples, 0, {});
  for (std::size_t i = 0; i < samples.sightings.size(); i += 97) samples.sightings[i].pixel.x() += 4.0;
  const IntrinsicsResult robust = calibrate_intrinsics(samples, 0, {});
  const IntrinsicsResult plain = calibrate_intrinsics(samples, 0, {.robust = false});
  const auto off = [&](const IntrinsicsResult& result) {
    return std::hypot(result.camera.cx_px - clean.camera.cx_px, result.camera.fx_px - clean.camera.fx_px);
  };
  EXPECT_LT(off(robust), 0.25 * off(plain));
}

TEST(Intrinsics, SaysWhenTheLensNeedsK3) {
  const CameraCalibration needs = lens(6, true), plain = lens(6, false);
  const auto advice = [](const CameraCalibration& truth) {
    const auto result = calibrate_intrinsics(seen(truth, session(truth, 25, 6), 0.03, 6), 0, {});
    return result.advice.empty() ? std::string() : result.advice.front();
  };
  EXPECT_TRUE(advice(needs).starts_with("--k3: this lens needs it")) << advice(needs);
  EXPECT_FALSE(advice(plain).starts_with("--k3")) << advice(plain);
}

TEST(Intrinsics, TheWordFollowsFromTheFigures) {
  const CameraCalibration truth = lens(7, false);
  const auto verdict = [&](std::size_t views, double sigma_px) {
    const IntrinsicsResult result =
        calibrate_intrinsics(seen(truth, session(truth, views, 7), sigma_px, 7), 0, {});
    EXPECT_FALSE(result.rule.empty());
    return result.verdict;
  };
  EXPECT_EQ(verdict(30, 0.1), Verdict::Excellent);
  EXPECT_EQ(verdict(6, 0.1), Verdict::Poor) << "no views to hold back: nothing is proven";
  EXPECT_EQ(verdict(30, 6.0), Verdict::Refuse);
}

TEST(Intrinsics, RefusesWhatCannotWorkAndSaysWhatToDo) {
  const CameraCalibration truth = lens(8, false);
  EXPECT_EQ(refusal(seen(truth, session(truth, 3, 8), 0.1, 8)),
            "cam1: only 3 different views of the board; show it in 5 at least, 20 are good");
  SampleSet none = seen(truth, {}, 0.1, 8);
  EXPECT_TRUE(refusal(none).starts_with("cam1: only 0 different views")) << refusal(none);
  const std::string flat = refusal(seen(truth, parallel(12), 0.05, 8));
  EXPECT_TRUE(flat.starts_with("cam1: all views of the board are within")) << flat;
  EXPECT_NE(flat.find("tilt the board by 20 to 45 degrees"), std::string::npos) << flat;

  std::vector<Pose> far = session(truth, 12, 8);
  for (Pose& pose : far) pose.translation *= 12.0;
  const std::string small = refusal(seen(truth, far, 0.05, 8));
  EXPECT_TRUE(small.starts_with("cam1: the board is too small in the image")) << small;

  SampleSet wand = seen(truth, session(truth, 12, 8), 0.1, 8);
  wand.target.kind = TargetKind::Wand;
  EXPECT_NE(refusal(wand).find("a lens is calibrated with a printed board"), std::string::npos);
}

TEST(Intrinsics, RefusesViewsOfTwoCamerasUnderOneName) {
  const CameraCalibration one = lens(9, false);
  CameraCalibration other = one;
  other.fx_px = other.fy_px = 1.5 * one.fx_px;
  SampleSet samples = seen(one, session(one, 10, 9), 0.1, 9);
  SampleSet more = seen(other, session(other, 10, 10), 0.1, 10);
  for (Sighting s : more.sightings) {
    s.tick += 100;
    samples.sightings.push_back(s);
  }
  const std::string said = refusal(samples);
  if (said.empty()) {
    EXPECT_EQ(calibrate_intrinsics(samples, 0, {}).verdict, Verdict::Refuse);
  } else {
    EXPECT_NE(said.find("contradict one another"), std::string::npos) << said;
  }
}

}  // namespace
}  // namespace glint
