// SPDX-License-Identifier: MIT
// Who is expected in which blob, and what its pixels say.
#include "host/match/pixel_look.hpp"

#include <algorithm>
#include <cmath>

#include "host/geometry/spread.hpp"
#include "host/geometry/triangulate.hpp"
#include "host/resolve/expected_disc.hpp"

namespace glint {
namespace {

constexpr double kVague_px =
    4.0;  // a track less certain than this (one sigma) cannot say what a blob is made of
// A marker that shines with so little of what is usual is not seen itself, but what something leaves of it;
// one that lacks so much light may be hidden in part.
constexpr double kDimShare = 0.4, kWholeShare = 0.75;
constexpr double kWholeSeen = 0.75;     // likewise, of the light that a fitted disc should have
constexpr double kPartialOffset = 0.2;  // what its place is then off by, in radii
constexpr double kSigmas = 3.0;
constexpr double kMargin_px = 1.0;    // around a blob's box: its outline lies outside of its pixels' centres
constexpr int kWindow_px = 2;         // of dark around the blob, for the background and the flanks
constexpr double kWorstChi2 = 3.0;    // per pixel: more, and discs are not what the pixels show
constexpr double kSecondShare = 0.1;  // so much more light than expected may come from a second marker
constexpr double kWorstSigma_px = 1.0;  // a disc that is placed no better is not placed
constexpr double kNoiseStep = 1.02, kLeastNoise = 0.25, kMostNoise = 1000.0;
// A radius that is taken from the blob's width, by so much too large or small, moves overlapping discs apart
// or together by as much. Of more whole blobs than so many times those that there is time for, to place some
// a little better helps nobody.
constexpr std::size_t kFewServed = 4;
constexpr double kCentroid_px = 0.1;  // what centroids of whole blobs err by, and no prediction is better
constexpr double kSizeUnknown = 0.08;
constexpr double kLeastStranger_px = 1.0;  // a radius below it says too little of what touches
constexpr std::size_t kReserved = 4096;

/// Of two discs alike the centres lie sqrt(l1 - l2) from the common centroid, l1 > l2 being the second
/// moments.
struct LongAxis {
  Eigen::Vector2d centroid_px, apart_px;
  double across_px2;
};

LongAxis long_axis(const shaders::BlobRecord& record) noexcept {
  const double xx = static_cast<double>(record.var_xx_px2), xy = static_cast<double>(record.var_xy_px2),
               yy = static_cast<double>(record.var_yy_px2);
  const double difference = 2.0 * std::hypot(0.5 * (xx - yy), xy),
               angle = 0.5 * std::atan2(2.0 * xy, xx - yy);
  return {{static_cast<double>(record.x_px), static_cast<double>(record.y_px)},
          std::sqrt(difference) * Eigen::Vector2d(std::cos(angle), std::sin(angle)),
          0.5 * (xx + yy - difference)};
}

}  // namespace

PixelLook::PixelLook(std::span<const Camera> cameras, const MatchOptions& options, BlobTable& table,
                     const ExpectedViews& expected)
    : cameras_(cameras),
      options_(options),
      table_(table),
      expected_(expected),
      fit_(PixelNoise{}),
      whole_(PixelNoise{}),
      noise_excess_(cameras.size()),
      usual_(cameras.size()) {
  wishes_.reserve(kReserved);
  needed_.reserve(kReserved);
  welcome_.reserve(kReserved);
  unexpected_.reserve(kReserved);
}

void PixelLook::look(std::span<const std::span<const shaders::BlobRecord>> records,
                     std::span<const gpu::ImageView> images, std::span<const Prediction> predictions,
                     MatchCounters& counters) {
  wishes_.clear();
  needed_.clear();
  welcome_.clear();
  unexpected_.clear();
  for (std::uint32_t camera = 0; camera < cameras_.size(); ++camera) {
    if (images[camera].pixels == nullptr || records[camera].empty()) continue;
    std::size_t first = wishes_.size();
    const std::size_t of_camera = first;
    collect(camera, records[camera], predictions);
    std::stable_sort(wishes_.begin() + static_cast<std::ptrdiff_t>(first), wishes_.end(),
                     [](const Wish& a, const Wish& b) { return a.blob < b.blob; });
    while (first < wishes_.size()) {
      std::size_t end = first + 1;
      while (end < wishes_.size() && wishes_[end].blob == wishes_[first].blob) ++end;
      const Look look{camera, static_cast<std::uint32_t>(first), static_cast<std::uint32_t>(end - first)};
      const std::span<const Wish> same(wishes_.data() + first, end - first);
      (needs_look(camera, records[camera][table_[same.front().blob].record], same) ? needed_ : welcome_)
          .push_back(look);
      first = end;
    }
    for (std::uint32_t blob = table_.begin_of(camera), wish = static_cast<std::uint32_t>(of_camera);
         blob < table_.end_of(camera); ++blob) {
      while (wish < wishes_.size() && wishes_[wish].blob < blob) ++wish;
      const bool expected = wish < wishes_.size() && wishes_[wish].blob == blob;
      if (!expected && table_[blob].elongated && table_[blob].usable) unexpected_.push_back(blob);
    }
  }
  std::size_t room = options_.most_looks;
  const auto take = [&](const Look& look) {
    const std::span<const Wish> same(wishes_.data() + look.first, look.count);
    resolve(look.camera, records[look.camera][table_[same.front().blob].record], images[look.camera], same,
            counters);
    --room;
  };
  for (std::size_t k = 0; k < needed_.size() && room > 0; ++k) take(needed_[k]);
  for (std::size_t k = 0; k < unexpected_.size() && room > 0; ++k, --room) {
    const std::uint32_t blob = unexpected_[k], camera = table_[blob].camera;
    ++(fit_strangers(camera, records[camera][table_[blob].record], images[camera], blob)
           ? counters.resolved
           : counters.unresolved);
  }
  if (welcome_.size() > kFewServed * room) return table_.settle();
  for (std::size_t k = 0; k < welcome_.size() && room > 0; ++k) take(welcome_[(turn_ + k) % welcome_.size()]);
  turn_ += options_.most_looks;
  table_.settle();
}

// Blobs in whose box a track expects its marker.
void PixelLook::collect(std::uint32_t camera, std::span<const shaders::BlobRecord> records,
                        std::span<const Prediction> predictions) {
  for (std::uint32_t k = 0; k < predictions.size(); ++k) {
    const Prediction& prediction = predictions[k];
    const ExpectedView& expected = expected_.of(k, camera);
    if (!expected.in_front) continue;
    const double sigma_px = std::sqrt(
        std::max(0.0, largest_variance(expected.spread_px2) + table_.calibration_variance_px2(camera)));
    if (!(sigma_px < kVague_px)) continue;
    const double own_px = options_.marker_radius_m * expected.by_position.row(0).norm();
    std::optional<ExpectedDisc> disc;
    const double slack = kMargin_px + kSigmas * sigma_px;
    // A blob of several markers is at most a few of them wide.
    table_.near(camera, expected.pixel, slack + 4.0 * own_px + 2.0, [&](std::uint32_t blob) {
      if (!disc) {
        disc = expected_disc(cameras_[camera], prediction.position_in_world, prediction.velocity_in_world,
                             options_.marker_radius_m, options_.exposure_s);
        if (!disc) return;
        disc->centre_px += expected.bias_px;
        disc->centre_error_px = std::clamp(kSigmas * sigma_px, kCentroid_px, disc->centre_error_px);
      }
      const shaders::BlobRecord& r = records[table_[blob].record];
      const double x = disc->centre_px.x(), y = disc->centre_px.y();
      if (x > static_cast<double>(r.x_min_px) - slack && x < static_cast<double>(r.x_max_px) + slack &&
          y > static_cast<double>(r.y_min_px) - slack && y < static_cast<double>(r.y_max_px) + slack)
        wishes_.push_back({blob, *disc, prediction.brightness});
    });
  }
}

bool PixelLook::needs_look(std::uint32_t camera, const shaders::BlobRecord& record,
                           std::span<const Wish> wishes) {
  // Two markers may be expected where one is, the other being hidden or somewhere near.
  for (const Wish& wish : wishes)
    if (whole_.may_be_whole(record, wish.disc, noise_excess_[camera])) {
      const double light = light_of(camera, whole_.grey(record, wish.disc), wish.disc);
      if (light < kDimShare * wish.brightness) continue;
      table_.whole(wish.blob, light);
      if (light < kWholeShare * wish.brightness) table_.suspect(wish.blob);
      return false;
    }
  return true;
}

void PixelLook::resolve(std::uint32_t camera, const shaders::BlobRecord& record, const gpu::ImageView& image,
                        std::span<const Wish> wishes, MatchCounters& counters) {
  const std::uint32_t blob = wishes.front().blob;
  std::array<ExpectedDisc, kMaxDiscs> discs;
  const std::size_t count = std::min(wishes.size(), kMaxDiscs);
  for (std::size_t k = 0; k < count; ++k) discs[k] = wishes[k].disc;
  const bool whole = table_[blob].radius_px == 0.0;
  bool found = false;
  if (whole) {  // its centroid is the better start
    discs[0].centre_px = {static_cast<double>(record.x_px), static_cast<double>(record.y_px)};
    discs[0].centre_error_px = kCentroid_px;
    discs[0].grey = whole_.grey(record, discs[0]);
  }
  if (count == 1 && !whole && whole_.deviation(record, discs[0]).weight > kSecondShare)
    found = fit_stranger(camera, record, image, blob, discs[0], 0.0);
  // Which of several a whole blob belongs to is not known here, and each has a size of its own.
  if (whole && count > 1) return;
  if (!found) found = fit(camera, record, image, blob, {discs.data(), count}, 0.0, wishes[0].brightness);
  for (std::size_t k = 0; count > 1 && k < count && !found; ++k)
    found = fit(camera, record, image, blob, {&discs[k], 1}, 0.0, wishes[k].brightness);
  if (!found && !whole) table_.doubt(blob, discs[0].radius_px());
  ++(found ? counters.resolved : counters.unresolved);
}

// A blob with one marker expected may show a second that no track knows of yet, or one that bounced into it.
bool PixelLook::fit_stranger(std::uint32_t camera, const shaders::BlobRecord& record,
                             const gpu::ImageView& image, std::uint32_t blob, const ExpectedDisc& expected,
                             double size_sd_px) {
  std::array<ExpectedDisc, 2> discs{expected, expected};
  const LongAxis axis = long_axis(record);
  discs[0].centre_px = axis.centroid_px + axis.apart_px;
  discs[1].centre_px = axis.centroid_px - axis.apart_px;
  if (fit(camera, record, image, blob, discs, size_sd_px, 1.0)) return true;
  std::swap(discs[0].centre_px, discs[1].centre_px);  // which is nearer, and hides the other, is not known
  return fit(camera, record, image, blob, discs, size_sd_px, 1.0);
}

// Nobody expects anything here, but no single marker is so long: two that touch, of a size that the blob's
// width tells to some per cent.
bool PixelLook::fit_strangers(std::uint32_t camera, const shaders::BlobRecord& record,
                              const gpu::ImageView& image, std::uint32_t blob) {
  constexpr std::array kSizes{1.0, 1.06, 0.94};
  const LongAxis axis = long_axis(record);
  const double radius_px = whole_.radius_px(record, axis.across_px2);
  if (!(radius_px > kLeastStranger_px)) return false;
  for (const double size : kSizes) {
    ExpectedDisc disc;
    disc.shape_px2 = size * size * radius_px * radius_px * Eigen::Matrix2d::Identity();
    if (fit_stranger(camera, record, image, blob, disc, kSizeUnknown * radius_px)) return true;
  }
  return false;
}

// In units of the usual brightness; 1 where that is not known.
double PixelLook::light_of(std::uint32_t camera, double grey, const ExpectedDisc& disc) const noexcept {
  const double usual = usual_[camera].grey(disc.radius_px());
  return usual > 0.0 ? grey / usual : 1.0;
}

bool PixelLook::shows_whole(std::uint32_t camera, const shaders::BlobRecord& record,
                            const Eigen::Vector3d& position_in_world) const noexcept {
  std::optional<ExpectedDisc> disc =
      expected_disc(cameras_[camera], position_in_world, Eigen::Vector3d::Zero(), options_.marker_radius_m,
                    options_.exposure_s);
  if (!disc) return true;
  disc->grey = usual_[camera].grey(disc->radius_px());
  return !(disc->grey > 0.0) || whole_.deviation(record, *disc).weight > kWholeShare - 1.0;
}

// What a camera's pixels err by is what its markers show: half of the fits should leave less than the noise
// that is assumed, and half more. A median does not mind the few that are not what they were taken for.
// Compressed frames are several times as noisy as raw ones.
void PixelLook::learn_noise(std::uint32_t camera, const FitQuality& quality) noexcept {
  const auto learn = [](double& excess, double chi2) {
    if (!(chi2 > 0.0)) return;
    excess = std::clamp(chi2 > 1.0 ? excess * kNoiseStep : excess / kNoiseStep, kLeastNoise, kMostNoise);
  };
  learn(noise_excess_[camera].dark, quality.dark_chi2);
  learn(noise_excess_[camera].light, quality.lit_chi2);
  table_.set_noise(camera, PixelNoise{}.with(noise_excess_[camera]));
}

bool PixelLook::fit(std::uint32_t camera, const shaders::BlobRecord& record, const gpu::ImageView& image,
                    std::uint32_t blob, std::span<const ExpectedDisc> discs, double size_sd_px,
                    double brightness) {
  const PixelBox box{
      static_cast<int>(record.x_min_px) - kWindow_px, static_cast<int>(record.y_min_px) - kWindow_px,
      static_cast<int>(record.x_max_px) + kWindow_px, static_cast<int>(record.y_max_px) + kWindow_px};
  std::array<FittedDisc, kMaxDiscs> fitted;
  FitQuality quality;
  if (!fit_.fit(image, box, discs, {fitted.data(), discs.size()}, quality, noise_excess_[camera]))
    return false;
  if (discs.size() == 1) learn_noise(camera, quality);
  if (!(quality.chi2_per_dof < kWorstChi2)) return false;
  std::array<OutlineCentre, kMaxDiscs> centres;
  for (std::size_t k = 0; k < discs.size(); ++k) {
    const auto centre =
        outline_centre(cameras_[camera], fitted[k].centre_px, discs[k].shape_px2, fitted[k].covariance_px2);
    if (!centre || !(largest_sigma(centre->covariance_px2) < kWorstSigma_px)) return false;
    centres[k] = *centre;
  }
  const bool alone = discs.size() == 1, seen = quality.seen_share > kWholeSeen;
  const double light = alone ? light_of(camera, fitted[0].grey, discs[0]) : 0.0;
  if (alone && light < kDimShare * brightness) return false;
  const bool partial = alone && (!seen || light < kWholeShare * brightness);
  if (alone && seen) usual_[camera].learn(fitted[0].grey, discs[0].radius_px());
  const double more_px = partial ? kPartialOffset * discs[0].radius_px() : size_sd_px;
  for (std::size_t k = 0; k < discs.size(); ++k)
    table_.resolve(blob, centres[k].normalized,
                   centres[k].covariance_px2 + more_px * more_px * Eigen::Matrix2d::Identity(), light,
                   partial);
  return true;
}

}  // namespace glint
