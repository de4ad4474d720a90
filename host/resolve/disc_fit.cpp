// SPDX-License-Identifier: MIT
// Robust Gauss-Newton over the pixels of a box.
#include "host/resolve/disc_fit.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>

#include "host/base/check.hpp"
#include "host/resolve/disc_model.hpp"
#include "host/resolve/hidden_pixels.hpp"
#include "host/resolve/normal_equations.hpp"

namespace glint {
namespace {

// The model (round profile, pixel as Gaussian, evenly bright disc) is right to about this share of the light.
constexpr float kModelError = 0.005f;
// Standard deviations at which a pixel is no longer believed, and up to which more light than expected counts
// in full while the centres are still unknown.
constexpr float kGone_sd = 5.0f, kBright_sd = 3.0f;
// What brightnesses may be wrong by at the start: no pixel is judged by more than that. After each step it
// and what centres may be wrong by are this share of how far the step went. A clipped disc's brightness is
// anybody's guess.
constexpr double kGuessedGreyShare = 0.05, kStartGreyShare = 0.3, kClippedGreyShare = 1.0,
                 kLeftAfterStep = 0.2;
// Mean of squared normal residuals weighted by that trust, over the mean trust; and the variance of what is
// fitted with such weights times the mean trust, over that of a plain fit's (by numerical integration).
constexpr double kTrustedChi2 = 0.847, kTrustedVariance = 0.96;
// Of what is half hidden some is never noticed and pulls at the disc: measured over discs hidden to 10-60 %.
constexpr double kHiddenShare = 0.02, kHiddenVariance = 4.0;
constexpr double kCentresKnown_px = 0.15;
constexpr double kErrorForgotten_px = 0.03;  // adds nothing to the noise of an edge any more
constexpr double kSmallStep_px = 0.02, kLargestStep_px = 1.0;
constexpr unsigned kMaxSteps = 25;
constexpr std::uint8_t kClipped = 255;
constexpr float kClipsAt_grey = 254.5f;
// Centres nearer to each other than this share of their mean radius are one disc, for all that is known.
constexpr double kSameDisc = 0.4;
// A centre worse known than this share of its radius is not known.
constexpr double kUnknownCentre = 0.5;
// A fit leaves more than its share by chance, up to so many standard deviations of chi2.
constexpr double kChance_sd = 2.0;
// A disc fainter than this many standard deviations of a dark pixel is not there.
constexpr double kFaintest_sd = 3.0;

constexpr float kLearntStep_grey = 1.0f / gpu::kBackgroundStepsPerGrey;
constexpr std::uint16_t kNothingLearnt = 0;

/// The pixels of a box that lie in the image.
struct Pixels {
  const std::uint8_t* first = nullptr;  // of the image
  std::size_t stride = 0;
  PixelBox box;
  bool empty() const noexcept { return box.x_min_px > box.x_max_px || box.y_min_px > box.y_max_px; }
  const std::uint8_t* row(int y) const noexcept { return first + static_cast<std::size_t>(y) * stride; }

  const std::uint16_t* learnt = nullptr;  // never null where not empty
  std::size_t learnt_stride = 0, learnt_step = 0;
  /// What column x of that row was learnt to show is learnt_at(learnt_row(y), x).
  const std::uint16_t* learnt_row(int y) const noexcept {
    return learnt + static_cast<std::size_t>(y) * learnt_stride;
  }
  float learnt_at(const std::uint16_t* row, int x) const noexcept {
    return static_cast<float>(row[static_cast<std::size_t>(x) * learnt_step]) * kLearntStep_grey;
  }
};

Pixels pixels_of(const gpu::ImageView& image, const PixelBox& box) noexcept {
  if (image.pixels == nullptr) return {};
  const bool knows = image.background != nullptr;
  return {image.pixels,
          image.stride_bytes,
          PixelBox{std::max(box.x_min_px, 0), std::max(box.y_min_px, 0),
                   std::min(box.x_max_px, static_cast<int>(image.width_px) - 1),
                   std::min(box.y_max_px, static_cast<int>(image.height_px) - 1)},
          knows ? image.background : &kNothingLearnt,
          knows ? image.width_px : 0u,
          knows ? 1u : 0u};
}

/// Median of the pixels that see no disc, over what was learnt; the darkest where there are few.
double background_of(const Pixels& pixels, PixelModel& model) noexcept {
  constexpr unsigned kFew = 8;
  constexpr int kBelow = 256;
  std::array<std::uint16_t, 512> count{};
  unsigned outside = 0;
  int darkest = 255;
  for (int y = pixels.box.y_min_px; y <= pixels.box.y_max_px; ++y) {
    int first = 0, last = -1;
    model.begin_row(y, first, last);
    const std::uint8_t* row = pixels.row(y);
    const std::uint16_t* learnt_row = pixels.learnt_row(y);
    for (int x = pixels.box.x_min_px; x <= pixels.box.x_max_px; ++x) {
      const int over_learnt = row[x] - static_cast<int>(pixels.learnt_at(learnt_row, x) + 0.5f);
      darkest = std::min(darkest, over_learnt);
      std::uint16_t& same = count[static_cast<std::size_t>(over_learnt + kBelow)];
      if ((x >= first && x <= last) || same == 0xffff) continue;
      ++same;
      ++outside;
    }
  }
  if (outside < kFew) return darkest;
  unsigned below = 0;
  std::size_t grey = 0;
  while ((below += count[grey]) * 2 < outside) ++grey;
  return static_cast<double>(grey) - kBelow;
}

struct Brightest {
  double grey = 0.0;  // above what was learnt
  bool clipped = false;
};

/// Of the 3 x 3 pixels about an expected centre.
Brightest brightest_near(const Pixels& pixels, const Eigen::Vector2d& centre_px) noexcept {
  const auto x0 = static_cast<int>(std::lround(centre_px.x())),
             y0 = static_cast<int>(std::lround(centre_px.y()));
  Brightest brightest;
  for (int y = std::max(y0 - 1, pixels.box.y_min_px); y <= std::min(y0 + 1, pixels.box.y_max_px); ++y)
    for (int x = std::max(x0 - 1, pixels.box.x_min_px); x <= std::min(x0 + 1, pixels.box.x_max_px); ++x)
      brightest = {std::max(brightest.grey, static_cast<double>(static_cast<float>(pixels.row(y)[x]) -
                                                                pixels.learnt_at(pixels.learnt_row(y), x))),
                   brightest.clipped || pixels.row(y)[x] == kClipped};
  return brightest;
}

/// What a pixel's residual is measured with.
struct Tolerance {
  float dark_variance, variance_per_grey;  // of the sensor
  float centre_variance_px2;               // of each coordinate: edges are not judged by more than that
  float light_share_squared;               // of the light, likewise
  bool bright_counts;                      // more light than expected is never disbelieved
};

struct Sums {
  float dark_chi2 = 0.0f, dark_believed = 0.0f, lit_chi2 = 0.0f, lit_believed = 0.0f;
  float expected_light = 0.0f, seen_light = 0.0f;
};

/// Of what counts as one measurement each; 0 where there are none to speak of.
double chi2_per_dof(double chi2, double dof) noexcept {
  return dof > 0.0 ? chi2 / (kTrustedChi2 * dof) : 0.0;
}

template <bool kOneDisc>
void accumulate(const Pixels& pixels, PixelModel& model, float background, const Tolerance& tolerance,
                NormalEquations& equations, HiddenPixels& hidden, Sums& sums) noexcept {
  constexpr float kGone = kGone_sd * kGone_sd;
  const float dark_weight = 1.0f / tolerance.dark_variance;
  PixelModel::Pixel pixel;
  OneDiscSums one;
  for (int y = pixels.box.y_min_px; y <= pixels.box.y_max_px; ++y) {
    int first = 0, last = -1;
    model.begin_row(y, first, last);
    const std::uint8_t* row = pixels.row(y);
    const std::uint16_t* learnt_row = pixels.learnt_row(y);
    float weights = 0.0f, weighted = 0.0f;
    for (int x = pixels.box.x_min_px; x <= pixels.box.x_max_px; ++x) {
      const float learnt = pixels.learnt_at(learnt_row, x);
      float value = static_cast<float>(row[x]) - learnt;
      if (x < first || x > last || !(kOneDisc ? model.at_only_disc(x, y, pixel) : model.at(x, y, pixel))) {
        const float residual = value - background, squared = residual * residual * dark_weight;
        if (squared >= kGone) continue;
        const float trust = (1.0f - squared / kGone) * (1.0f - squared / kGone);
        sums.dark_chi2 += trust * squared;
        sums.dark_believed += trust;
        weights += trust * dark_weight;
        weighted += trust * dark_weight * residual;
        continue;
      }
      sums.expected_light += pixel.light;
      if (row[x] == kClipped) {  // only that it is not darker is known
        value = kClipsAt_grey - learnt;
        if (background + pixel.light >= value) {
          sums.seen_light += pixel.light;
          continue;
        }
      }
      const float residual = value - background - pixel.light;
      float gradient = 0.0f;
      for (std::size_t n = 0; n < (kOneDisc ? 1 : pixel.discs); ++n)
        gradient += pixel.by_x[n] * pixel.by_x[n] + pixel.by_y[n] * pixel.by_y[n];
      const float variance = tolerance.dark_variance + tolerance.variance_per_grey * pixel.light +
                             tolerance.light_share_squared * pixel.light * pixel.light +
                             tolerance.centre_variance_px2 * gradient;
      const float inverse = 1.0f / variance;
      const float squared = residual * residual * inverse;
      float trust = 1.0f;
      if (tolerance.bright_counts && residual > 0.0f) {
        if (squared > kBright_sd * kBright_sd) trust = kBright_sd / std::sqrt(squared);
      } else {
        if (squared >= kGone) {
          if (residual < 0.0f) hidden.found(x, y);
          continue;
        }
        if (hidden.near(x, y)) continue;
        trust = (1.0f - squared / kGone) * (1.0f - squared / kGone);
      }
      const bool lit = tolerance.variance_per_grey * pixel.light > tolerance.dark_variance;
      (lit ? sums.lit_chi2 : sums.dark_chi2) += trust * squared;
      (lit ? sums.lit_believed : sums.dark_believed) += trust;
      sums.seen_light += pixel.light;
      if constexpr (kOneDisc) {
        one.add(pixel.by_x[0], pixel.by_y[0], pixel.by_grey[0], residual, trust * inverse);
      } else {
        equations.add(pixel, residual, trust * inverse);
      }
    }
    equations.add_dark(weights, weighted);
  }
  if constexpr (kOneDisc) equations.add(one);
}

/// Covariances, and whether the fit is one that may be believed.
bool finish(std::span<FittedDisc> fitted, const NormalEquations& equations, const PixelModel& model,
            const FitQuality& quality, double dof, double dark_variance_grey2) noexcept {
  // By how much chi2 goes beyond what chance may do.
  const double beyond = quality.chi2_per_dof / (1.0 + kChance_sd * std::sqrt(2.0 / dof));
  const double scale = kTrustedVariance * std::max(1.0, beyond) *
                       (quality.seen_share < 1.0 - kHiddenShare ? kHiddenVariance : 1.0);
  for (std::size_t i = 0; i < fitted.size(); ++i) {
    if (fitted[i].grey * fitted[i].grey < kFaintest_sd * kFaintest_sd * dark_variance_grey2) return false;
    fitted[i].covariance_px2 = scale * equations.centre_covariance_px2(i);
    const double unknown = kUnknownCentre * model.radius_px(i);
    if (!(fitted[i].covariance_px2.trace() < unknown * unknown)) return false;
    for (std::size_t j = 0; j < i; ++j) {
      const double same = kSameDisc * 0.5 * (model.radius_px(i) + model.radius_px(j));
      if ((fitted[i].centre_px - fitted[j].centre_px).squaredNorm() < same * same) return false;
    }
  }
  return true;
}

}  // namespace

DiscFit::DiscFit(const PixelNoise& noise) : noise_(noise), profiles_(noise.psf_sigma_px) {}

bool DiscFit::fit(const gpu::ImageView& image, const PixelBox& box, std::span<const ExpectedDisc> expected,
                  std::span<FittedDisc> fitted, FitQuality& quality, const NoiseExcess& excess) noexcept {
  GLINT_CHECK(expected.size() <= kMaxDiscs && fitted.size() == expected.size());
  quality = {};
  const Pixels pixels = pixels_of(image, box);
  const std::size_t count = expected.size();
  if (pixels.empty() || count == 0) return false;

  // The nearest first.
  std::array<std::size_t, kMaxDiscs> order{};
  for (std::size_t i = 0; i < count; ++i) {
    if (!expected[i].centre_px.allFinite()) return false;
    std::size_t at = i;
    for (; at > 0 && expected[order[at - 1]].distance_m > expected[i].distance_m; --at)
      order[at] = order[at - 1];
    order[at] = i;
  }
  std::array<ExpectedDisc, kMaxDiscs> sorted;
  std::array<FittedDisc, kMaxDiscs> found;
  for (std::size_t i = 0; i < count; ++i) sorted[i] = expected[order[i]];
  const std::span<const ExpectedDisc> wanted(sorted.data(), count);
  const std::span<FittedDisc> discs(found.data(), count);

  PixelModel model(wanted, profiles_, overlap_);
  for (std::size_t i = 0; i < count; ++i) model.set(i, wanted[i].centre_px, 0.0);
  double background = background_of(pixels, model), grey_error = kGuessedGreyShare;
  for (std::size_t i = 0; i < count; ++i) {
    discs[i].centre_px = wanted[i].centre_px;
    const Brightest seen = brightest_near(pixels, wanted[i].centre_px);
    discs[i].grey = wanted[i].grey > 0.0 ? wanted[i].grey : std::max(1.0, seen.grey - background);
    if (!(wanted[i].grey > 0.0)) grey_error = std::max(grey_error, kStartGreyShare);
    if (seen.clipped) grey_error = kClippedGreyShare;
  }

  const PixelNoise noise = noise_.with(excess);
  const double dark_variance =
      image.background != nullptr ? noise.variance_over_time_grey2(0.0) : noise.variance_grey2(0.0);
  NormalEquations equations(count);
  HiddenPixels hidden(pixels.box);
  double position_error = 0.0;
  for (const ExpectedDisc& disc : wanted) position_error = std::max(position_error, disc.centre_error_px);
  for (unsigned step = 1; step <= kMaxSteps; ++step) {
    for (std::size_t i = 0; i < count; ++i) model.set(i, discs[i].centre_px, discs[i].grey);
    equations.clear();
    // Half of the squared error belongs to each direction.
    const Tolerance tolerance{static_cast<float>(dark_variance),
                              static_cast<float>(noise.grey_variance_per_grey),
                              static_cast<float>(0.5 * position_error * position_error),
                              kModelError * kModelError + static_cast<float>(grey_error * grey_error),
                              position_error > kCentresKnown_px};
    hidden.next_step();
    Sums sums;
    (count == 1 ? accumulate<true> : accumulate<false>)(pixels, model, static_cast<float>(background),
                                                        tolerance, equations, hidden, sums);
    for (std::size_t i = 0; i < count; ++i)
      if (wanted[i].grey > 0.0 && wanted[i].grey_sd > 0.0)
        equations.add_grey(i, wanted[i].grey - discs[i].grey, 1.0 / (wanted[i].grey_sd * wanted[i].grey_sd));
    if (!equations.solve()) return false;

    double longest = 0.0, brighter = 0.0;
    for (std::size_t i = 0; i < count; ++i) {
      Eigen::Vector2d move = equations.centre_step(i);
      const double length = move.norm();
      longest = std::max(longest, length);
      if (length > kLargestStep_px) move *= kLargestStep_px / length;
      discs[i].centre_px += move;
      const double before = discs[i].grey;
      discs[i].grey = std::clamp(before + equations.grey_step(i), 0.5 * before, 2.0 * before);
      brighter = std::max(brighter, std::abs(discs[i].grey - before) / discs[i].grey);
    }
    background += equations.background_step();
    if (longest < kSmallStep_px && position_error < kErrorForgotten_px) {
      const auto dark = static_cast<double>(sums.dark_believed), lit = static_cast<double>(sums.lit_believed);
      const auto parameters = static_cast<double>(3 * count);
      const double dof = dark + lit - parameters - 1.0;
      if (!(dof > 0.0)) return false;
      quality = {
          background,
          chi2_per_dof(static_cast<double>(sums.dark_chi2 + sums.lit_chi2), dof),
          chi2_per_dof(static_cast<double>(sums.dark_chi2), dark - 1.0),
          chi2_per_dof(static_cast<double>(sums.lit_chi2), lit - parameters),
          sums.expected_light > 0.0f ? static_cast<double>(sums.seen_light / sums.expected_light) : 0.0,
          step};
      const bool good = finish(discs, equations, model, quality, dof, dark_variance);
      for (std::size_t i = 0; i < count; ++i) fitted[order[i]] = discs[i];
      return good;
    }
    position_error = std::min(position_error, kLeftAfterStep * longest);
    grey_error = std::min(grey_error, kLeftAfterStep * brighter);
  }
  return false;
}

}  // namespace glint
