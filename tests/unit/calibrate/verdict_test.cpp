// SPDX-License-Identifier: MIT
// The word that a calibration gets, figure by figure.
#include "host/calibrate/verdict.hpp"

#include <cmath>
#include <functional>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace glint {
namespace {

using testing::Contains;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::Not;

/// A wand calibration of four cameras with nothing to object to.
struct Case {
  CalibrationQuality quality;
  std::vector<CoverageGrid> coverage;
  Overlap overlap{4};
  ExpectedErrorSummary expected;
  TargetKind target = TargetKind::Wand;

  Case() {
    for (int i = 1; i <= 4; ++i) {
      CameraQuality camera;
      camera.name = "cam" + std::to_string(i);
      camera.fit_px = {4000, 0.1, 0.12, 0.1, 0.2, 0.5};
      camera.held_out_px = {1000, 0.1, 0.12, 0.1, 0.2, 0.5};
      quality.cameras.push_back(camera);
      CoverageGrid grid(1280, 800);
      for (int x = 50; x < 1280; x += 100)
        for (int y = 50; y < 800; y += 100) grid.add({x, y});
      coverage.push_back(grid);
    }
    quality.sightings_used = 16000;
    quality.sightings_held_out = 4000;
    quality.fit_rms_px = quality.held_out_rms_px = 0.12;
    quality.lengths = {{0, 1, 0.13, 0.13001, 2e-4, {300, 1e-4, 2e-4, 1e-4, 5e-4, 9e-4}},
                       {0, 2, 0.39, 0.39001, 2e-4, {300, 1e-4, 2e-4, 1e-4, 5e-4, 9e-4}}};
    for (int i = 0; i < 500; ++i) overlap.add(std::vector<std::uint32_t>{0, 1, 2, 3});
    expected.places = 500;
    expected.total_m = expected.noise_m = {500, 2e-4, 2e-4, 2e-4, 3e-4, 4e-4};
    expected.calibration_m = {500, 1e-4, 1e-4, 1e-4, 1e-4, 2e-4};
  }

  Judgement judgement() const { return judge({&quality, coverage, &overlap, expected, target}); }
};

Judgement after(const std::function<void(Case&)>& change) {
  Case changed;
  change(changed);
  return changed.judgement();
}

TEST(Verdict, ExcellentHasNothingToImprove) {
  const Judgement judgement = Case().judgement();
  EXPECT_EQ(judgement.verdict, Verdict::Excellent);
  EXPECT_THAT(judgement.reasons(), IsEmpty());
  EXPECT_THAT(judgement.rule, HasSubstr("excellent means"));
  EXPECT_THAT(judgement.rule, HasSubstr("held-out error of the worst camera at most 0.5 px"));
  EXPECT_THAT(judgement.rule, HasSubstr("error of 95 % of the known lengths at most 0.3 %"));
  EXPECT_EQ(judgement.criteria.size(), 9u);
}

struct Step {
  const char* name;
  std::function<void(Case&)> change;
  Verdict verdict;
  const char* reason;
};

TEST(Verdict, TheWorstFigureDecides) {
  const auto rms = [](double px) { return [px](Case& c) { c.quality.cameras[2].held_out_px.rms = px; }; };
  const auto p95 = [](double m) { return [m](Case& c) { c.quality.lengths[1].error_m.p95 = m; }; };
  const auto mean = [](double m) { return [m](Case& c) { c.quality.lengths[1].mean_m = m; }; };
  const auto count = [](std::uint64_t n) { return [n](Case& c) { c.quality.cameras[1].fit_px.count = n; }; };
  const auto out = [](std::uint64_t n) { return [n](Case& c) { c.quality.cameras[3].outliers = n; }; };
  const auto fitted = [](double px) { return [px](Case& c) { c.quality.cameras[0].fit_px.p50 = px; }; };
  const auto added = [](double m) { return [m](Case& c) { c.expected.calibration_m.p95 = m; }; };
  const std::vector<Step> steps{
      {"published wand", rms(0.71), Verdict::Good, "0.71 px rms (cam3)"},
      {"webcams without trigger", rms(1.56), Verdict::Poor, "1.56 px rms (cam3)"},
      {"stray", rms(0.9), Verdict::Good, "a few of its sightings are far off, up to 0.5 px"},
      {"nonsense", rms(3.2), Verdict::Refuse, "3.2 px rms (cam3)"},
      {"length scatters", p95(2e-3), Verdict::Good, "0.513 % of 390 mm"},
      {"length scatters more", p95(6e-3), Verdict::Poor, "1.5 % of 390 mm"},
      {"length scatters widely", p95(2e-2), Verdict::Refuse, "5.1 % of 390 mm"},
      {"length too long", mean(0.391), Verdict::Good, "0.256 % of 390 mm"},
      {"length too short", mean(0.387), Verdict::Poor, "0.769 % of 390 mm"},
      {"wrong wand", mean(0.40), Verdict::Refuse, "2.6 % of 390 mm"},
      {"few", count(300), Verdict::Good, "300 (cam2)"},
      {"fewer", count(199), Verdict::Poor, "199 (cam2)"},
      {"hardly any", count(20), Verdict::Refuse, "20 (cam2)"},
      {"outliers", out(200), Verdict::Good, "3.8 % (cam4)"},
      {"more outliers", out(1000), Verdict::Poor, "16.7 % (cam4)"},
      {"mostly outliers", out(5000), Verdict::Refuse, "50 % (cam4)"},
      {"fits its own samples better", fitted(0.075), Verdict::Good,
       "median held-out error over median fitted error: 1.33 (cam1)"},
      {"calibration adds as much as noise", added(4e-4), Verdict::Good, "over that by noise: 1.33"},
      {"calibration adds more than noise", added(3e-3), Verdict::Poor, "over that by noise: 10"},
      {"nothing held out", [](Case& c) { c.quality.sightings_held_out = 0; }, Verdict::Poor,
       "nothing was held out"},
      {"no length", [](Case& c) { c.quality.lengths.clear(); }, Verdict::Good, "the target has none"},
      {"corner only",
       [](Case& c) {
         c.coverage[0] = CoverageGrid(1280, 800);
         for (int i = 0; i < 100; ++i) c.coverage[0].add({10, 10});
       },
       Verdict::Poor, "2.5 % (cam1): cam1: nothing yet in the bottom, the right"},
      {"split", [](Case& c) { c.overlap = Overlap(4); }, Verdict::Refuse, "4 groups"},
  };
  for (const Step& step : steps) {
    const Judgement judgement = after(step.change);
    EXPECT_EQ(judgement.verdict, step.verdict) << step.name;
    EXPECT_THAT(judgement.reasons(), Contains(HasSubstr(step.reason))) << step.name;
    EXPECT_EQ(judgement.reasons().size(), 1u) << step.name;
    EXPECT_EQ(judgement.criteria.front().level, step.verdict) << step.name;
    EXPECT_FALSE(judgement.criteria.front().remedy.empty()) << step.name;
  }
}

TEST(Verdict, RefusalNamesTheBrokenLimits) {
  const Judgement judgement = after([](Case& c) { c.quality.cameras[2].held_out_px.rms = 9; });
  EXPECT_THAT(judgement.rule, HasSubstr("held-out error of the worst camera"));
  EXPECT_THAT(judgement.rule, HasSubstr("refused"));
}

TEST(Verdict, ScatterOfABoardsShortSquaresIsNotJudged) {
  const auto change = [](TargetKind kind) {
    return after([kind](Case& c) {
      c.target = kind;
      c.quality.lengths = {{0, 1, 0.054, 0.05401, 5e-4, {300, 5e-4, 5e-4, 5e-4, 1e-3, 2e-3}}};
    });
  };
  EXPECT_EQ(change(TargetKind::Wand).verdict, Verdict::Poor);
  EXPECT_EQ(change(TargetKind::Board).verdict, Verdict::Excellent);
}

TEST(Verdict, WhatIsNotANumberIsRefused) {
  EXPECT_EQ(after([](Case& c) { c.quality.cameras[0].held_out_px.rms = std::nan(""); }).verdict,
            Verdict::Refuse);
  const CalibrationQuality none;
  EXPECT_EQ(judge({&none, {}, nullptr, {}}).verdict, Verdict::Refuse);
}

TEST(Verdict, Words) {
  EXPECT_STREQ(word_of(Verdict::Excellent), "excellent");
  EXPECT_STREQ(word_of(Verdict::Refuse), "refuse");
}

TEST(Verdict, OfOneCameraPlacedAnewTheOthersDoNotCount) {
  Case rig;
  rig.quality.cameras[3].fit_px = {};
  rig.coverage[3] = CoverageGrid(1280, 800);
  EXPECT_EQ(rig.judgement().verdict, Verdict::Refuse);
  const std::vector<std::uint32_t> anew{1};
  EXPECT_EQ(judge({&rig.quality, rig.coverage, &rig.overlap, rig.expected, rig.target, anew}).verdict,
            Verdict::Excellent);
}

}  // namespace
}  // namespace glint
