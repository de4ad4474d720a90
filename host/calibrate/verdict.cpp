// SPDX-License-Identifier: MIT
// The rule: each figure has limits for excellent, good and poor, and the worst figure decides.
#include "host/calibrate/verdict.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <limits>
#include <utility>

#include "host/base/check.hpp"

namespace glint {
namespace {

constexpr double kNever = std::numeric_limits<double>::infinity();

/// Limits for excellent, good and poor; beyond the last, the calibration is refused.
using Limits = std::array<double, 3>;

// Held-out error of a camera, rms. Markers are found to 0.02-0.2 px, and a fit by a good lens model stays
// below 0.5 px. Published wand calibrations of cheap triggered cameras report 0.5-0.7 px. Webcams without a
// trigger reach 1.5 px, because each sees the target at another moment: that tracks slow motion, to a
// centimetre. Beyond 3 px the matching of blobs between cameras goes wrong.
constexpr Limits kHeldOut_px{0.5, 1.0, 3.0};
// Of the wand's longest distance, 95 % of the held-out measurements are nearer than this. 0.3 % of 39 cm
// is 1.2 mm.
constexpr Limits kLengthP95{0.003, 0.01, 0.03};
// The mean of many: noise averages out, and what is left is scale or a bent volume.
constexpr Limits kLengthBias{0.001, 0.003, 0.01};
// Held-out over fitted error: a model with enough samples fits both alike. Medians, since the fit leaves
// stray sightings out, and who judges must not.
constexpr Limits kOverfit{1.25, 1.5, 3.0};
// What the cameras' uncertain poses add to a point, over what the noise of one exposure does. Below 1 the
// next improvement is a better picture, above it more samples. A calibration is not refused for this: it is
// honest.
constexpr Limits kAdded{1.0, 2.0, kNever};
// Sightings of the camera with fewest. 50 determine a pose to a few millimetres, 500 to the noise.
constexpr Limits kSightings{500.0, 200.0, 50.0};
// Share of the 8 x 5 cells of an image in which the target was seen at all. Where it was not, the lens is a
// guess.
constexpr Limits kCovered{0.6, 0.4, 0.0};
// Share of sightings left out because they fitted far too badly: reflections, other markers, late frames.
constexpr Limits kOutliers{0.02, 0.1, 0.3};

std::string number(double value, int decimals) {
  char text[64];
  std::snprintf(text, sizeof text, "%.*f", decimals, value);
  std::string s(text);
  if (s.find('.') != std::string::npos) {
    s.erase(s.find_last_not_of('0') + 1);
    if (s.back() == '.') s.pop_back();
  }
  return s;
}

std::string px(double value) { return number(value, value < 1 ? 3 : 2) + " px"; }
std::string ratio(double value) { return number(value, 2); }
std::string percent(double share) { return number(100.0 * share, share < 0.01 ? 3 : 1) + " %"; }
std::string whole(double value) { return number(value, 0); }

using Text = std::string (*)(double);

/// `high_is_good` turns the comparison round.
Criterion judged(std::string name, double value, Text text, const std::string& after, const Limits& limits,
                 bool high_is_good, std::string remedy) {
  Criterion c;
  c.name = std::move(name);
  c.measured = text(value) + after;
  c.remedy = std::move(remedy);
  c.level = Verdict::Refuse;
  for (std::size_t i = limits.size(); i-- > 0;) {
    const bool open = limits[i] == kNever || (high_is_good && limits[i] == 0.0);
    if (!open) c.limits[i] = (high_is_good ? "at least " : "at most ") + text(limits[i]);
    if (high_is_good ? value >= limits[i] : value <= limits[i]) c.level = static_cast<Verdict>(i);
  }
  return c;
}

Criterion not_proved(std::string name, std::string measured, Verdict level, std::string remedy) {
  return {std::move(name), std::move(measured), {}, level, std::move(remedy)};
}

/// Index of the camera for which `of` is largest.
template <typename Of>
std::size_t worst_of(std::size_t count, Of of) {
  std::size_t worst = 0;
  for (std::size_t i = 1; i < count; ++i)
    if (of(i) > of(worst)) worst = i;
  return worst;
}

double share_left_out(const CameraQuality& camera) {
  const auto all = camera.fit_px.count + camera.held_out_px.count + camera.outliers;
  return all > 0 ? static_cast<double>(camera.outliers) / static_cast<double>(all) : 0.0;
}

void judge_residuals(const CalibrationQuality& quality, std::vector<Criterion>& criteria) {
  const auto& cameras = quality.cameras;
  const auto worst = worst_of(cameras.size(), [&](auto i) { return cameras[i].held_out_px.rms; });
  if (quality.sightings_held_out == 0) {
    criteria.push_back(
        not_proved("held-out error", "nothing was held out", Verdict::Poor,
                   "let a fifth of the samples be kept back, so that the accuracy can be proved"));
  } else {
    const ErrorSummary& error = cameras[worst].held_out_px;
    // Without stray ones the rms lies far below the 95 % mark (at 0.58 of it for normal errors).
    const std::string remedy = error.rms > error.p95
                                   ? "a few of its sightings are far off, up to " + px(error.max) +
                                         ": cover or mask reflections and other markers"
                                   : "check that the cameras are triggered together and nothing has moved; "
                                     "calibrate the intrinsics of " +
                                         cameras[worst].name + " again; shorten the exposure";
    criteria.push_back(judged("held-out error of the worst camera", error.rms, px,
                              " rms (" + cameras[worst].name + ")", kHeldOut_px, false, remedy));
    const auto over = [&](std::size_t i) {
      return cameras[i].fit_px.p50 > 0 ? cameras[i].held_out_px.p50 / cameras[i].fit_px.p50 : 0.0;
    };
    const auto most = worst_of(cameras.size(), over);
    criteria.push_back(judged("median held-out error over median fitted error", over(most), ratio,
                              " (" + cameras[most].name + ")", kOverfit, false,
                              "take more samples, all over the volume"));
  }
  const auto least =
      worst_of(cameras.size(), [&](auto i) { return -static_cast<double>(cameras[i].fit_px.count); });
  criteria.push_back(judged("sightings of the camera with fewest",
                            static_cast<double>(cameras[least].fit_px.count), whole,
                            " (" + cameras[least].name + ")", kSightings, true,
                            "wave the target longer where " + cameras[least].name + " sees it"));
  const auto odd = worst_of(cameras.size(), [&](auto i) { return share_left_out(cameras[i]); });
  criteria.push_back(judged("sightings left out", share_left_out(cameras[odd]), percent,
                            " (" + cameras[odd].name + ")", kOutliers, false,
                            "cover or mask reflections and other markers; check that " + cameras[odd].name +
                                " delivers its frames in time"));
}

void judge_lengths(const CalibrationQuality& quality, TargetKind target, std::vector<Criterion>& criteria) {
  if (quality.lengths.empty()) {
    criteria.push_back(not_proved("known lengths", "the target has none", Verdict::Good,
                                  "use a wand, so that the scale and the shape of the volume are proved"));
    return;
  }
  // The longest says most: noise is a smaller part of it.
  const LengthQuality& length =
      *std::max_element(quality.lengths.begin(), quality.lengths.end(),
                        [](const auto& a, const auto& b) { return a.true_m < b.true_m; });
  GLINT_CHECK(length.true_m > 0);
  const std::string of = " of " + number(1e3 * length.true_m, 2) + " mm";
  criteria.push_back(
      judged("mean error of the known length", std::abs(length.mean_m - length.true_m) / length.true_m,
             percent, of, kLengthBias, false,
             "measure the target again, to a tenth of a millimetre; take samples all over the volume"));
  if (target == TargetKind::Board) return;  // its squares are short: their scatter is that of the noise
  criteria.push_back(judged("error of 95 % of the known lengths", length.error_m.p95 / length.true_m, percent,
                            of, kLengthP95, false,
                            "shorten the exposure, wave more slowly, and take samples all over the volume"));
}

void judge_views(const VerdictInput& input, std::vector<Criterion>& criteria) {
  const auto& cameras = input.quality->cameras;
  if (!input.coverage.empty()) {
    const auto worst = worst_of(cameras.size(), [&](auto i) { return -input.coverage[i].share(); });
    const std::string where = input.coverage[worst].sentence();
    criteria.push_back(
        judged("part of the image that was covered", input.coverage[worst].share(), percent,
               " (" + cameras[worst].name + ")", kCovered, true,
               cameras[worst].name + ": " + (where.empty() ? "show the target near the edges" : where)));
  }
  if (input.overlap != nullptr && cameras.size() > 1) {
    const std::uint64_t wanted = input.target == TargetKind::Board ? 5 : 50;
    const auto groups = input.overlap->groups(wanted);
    const bool joined = groups.size() == 1;
    std::vector<std::string> names;
    names.reserve(cameras.size());
    for (const CameraQuality& camera : cameras) names.push_back(camera.name);
    const auto sentences = input.overlap->sentences(names, wanted);
    Criterion c = not_proved(
        "cameras joined by common samples", joined ? "all" : std::to_string(groups.size()) + " groups",
        joined ? Verdict::Excellent : Verdict::Refuse,
        sentences.empty() ? "show the target where two cameras see it" : sentences.front());
    c.limits[0] = "all, by " + std::to_string(wanted) + " common samples";
    criteria.push_back(std::move(c));
  }
  if (input.expected && input.expected->noise_m.p95 > 0 && input.expected->calibration_m.p95 > 0) {
    criteria.push_back(judged("error of a point by the calibration, over that by noise",
                              input.expected->calibration_m.p95 / input.expected->noise_m.p95, ratio, "",
                              kAdded, false, "take more samples, all over the volume"));
  } else {
    criteria.push_back(not_proved("error of a point by the calibration", "not known", Verdict::Good,
                                  "calibrate from samples, so that the uncertainty is computed"));
  }
}

/// What a word demands, from the limits that the criteria have for it.
std::string rule_for(Verdict verdict, const std::vector<Criterion>& criteria) {
  std::string rule;
  const auto word = static_cast<std::size_t>(verdict);
  if (verdict == Verdict::Refuse) {
    std::vector<std::string> broken;
    for (const Criterion& c : criteria)
      if (c.level == Verdict::Refuse) broken.push_back(c.name);
    return "The worst figure decides: refused, because even \"poor\" has limits that are not kept (" +
           list_in_words(broken) + ").";
  }
  for (const Criterion& c : criteria)
    if (!c.limits[word].empty()) rule += (rule.empty() ? "" : "; ") + c.name + " " + c.limits[word];
  return std::string("The worst figure decides: ") + word_of(verdict) + " means " + rule + ".";
}

}  // namespace

const char* word_of(Verdict verdict) {
  switch (verdict) {
    case Verdict::Excellent:
      return "excellent";
    case Verdict::Good:
      return "good";
    case Verdict::Poor:
      return "poor";
    case Verdict::Refuse:
      break;
  }
  return "refuse";
}

std::vector<std::string> Judgement::reasons() const {
  std::vector<std::string> reasons;
  for (const Criterion& c : criteria)
    if (c.level != Verdict::Excellent) reasons.push_back(c.name + ": " + c.measured + ": " + c.remedy);
  return reasons;
}

Judgement judge(const VerdictInput& input) {
  if (!input.only.empty()) {
    CalibrationQuality quality = *input.quality;
    quality.cameras.clear();
    std::vector<CoverageGrid> coverage;
    for (const std::uint32_t camera : input.only) {
      quality.cameras.push_back(input.quality->cameras[camera]);
      if (!input.coverage.empty()) coverage.push_back(input.coverage[camera]);
    }
    return judge({&quality, coverage, nullptr, input.expected, input.target, {}});
  }
  GLINT_CHECK(input.quality != nullptr);
  GLINT_CHECK(input.coverage.empty() || input.coverage.size() == input.quality->cameras.size());
  Judgement judgement;
  if (input.quality->cameras.empty()) {
    judgement.rule = "Refused: no cameras.";
    return judgement;
  }
  judge_residuals(*input.quality, judgement.criteria);
  judge_lengths(*input.quality, input.target, judgement.criteria);
  judge_views(input, judgement.criteria);
  std::stable_sort(judgement.criteria.begin(), judgement.criteria.end(),
                   [](const Criterion& a, const Criterion& b) { return a.level > b.level; });
  judgement.verdict = judgement.criteria.front().level;
  judgement.rule = rule_for(judgement.verdict, judgement.criteria);
  return judgement;
}

}  // namespace glint
