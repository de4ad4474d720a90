// SPDX-License-Identifier: MIT
// Claims, fits, and letting go.
#include "host/body/body_state.hpp"

#include <algorithm>

#include <Eigen/LU>

#include "host/body/point_pose.hpp"

namespace glint {

void SampleIndex::fill(std::span<const MarkerSample> samples) {
  samples_ = samples;
  used_.assign(samples.size(), 0);
  by_track_.clear();
  for (std::uint32_t k = 0; k < samples.size(); ++k) {
    by_track_.push_back(k);
    // What has no place cannot be found by it, nor belong to a rigid body.
    if (!samples[k].position_in_world.allFinite() || samples[k].views.empty()) used_[k] = 1;
  }
  by_x_.clear();
  for (const std::uint32_t k : by_track_)
    if (used_[k] == 0) by_x_.push_back(k);
  std::sort(by_track_.begin(), by_track_.end(), [samples](std::uint32_t a, std::uint32_t b) {
    return samples[a].track != samples[b].track ? number(samples[a].track) < number(samples[b].track) : a < b;
  });
  std::sort(by_x_.begin(), by_x_.end(), [samples](std::uint32_t a, std::uint32_t b) {
    const double xa = samples[a].position_in_world.x(), xb = samples[b].position_in_world.x();
    return xa != xb ? xa < xb : a < b;
  });
}

std::uint32_t SampleIndex::of_track(TrackId track) const noexcept {
  const auto found = std::lower_bound(
      by_track_.begin(), by_track_.end(), track,
      [this](std::uint32_t k, TrackId id) { return number(samples_[k].track) < number(id); });
  return found != by_track_.end() && samples_[*found].track == track ? *found : kNoSample;
}

std::size_t SampleIndex::first_beyond(double x) const noexcept {
  return static_cast<std::size_t>(std::lower_bound(by_x_.begin(), by_x_.end(), x,
                                                   [this](std::uint32_t k, double limit) {
                                                     return samples_[k].position_in_world.x() < limit;
                                                   }) -
                                  by_x_.begin());
}

void BodyFitter::claim(const ShapedBody& shaped, BodyState& body, SampleIndex& index) const noexcept {
  body.sample.fill(kNoSample);
  body.fitted = body.jumped = false;
  body.markers = 0;
  if (body.life == BodyLife::Lost) return;
  for (std::size_t m = 0; m < shaped.markers_in_shape.size(); ++m) {
    if (body.track[m] == TrackId{}) continue;
    const std::uint32_t sample = index.of_track(body.track[m]);
    if (sample == kNoSample || index.used(sample)) continue;
    body.sample[m] = sample;
    index.use(sample, true);
  }
}

void BodyFitter::collect(const ShapedBody& shaped, BodyState& body, const SampleIndex& index) {
  views_.clear();
  body.markers = 0;
  for (std::uint32_t m = 0; m < shaped.markers_in_shape.size(); ++m) {
    if (body.sample[m] == kNoSample) continue;
    ++body.markers;
    for (const Observation& view : index.samples()[body.sample[m]].views)
      views_.push_back({view.camera, view.normalized, view.covariance_px2, m});
  }
  outlier_.assign(views_.size(), 0);
}

bool BodyFitter::try_fit(const ShapedBody& shaped, BodyState& body, const Pose& start,
                         const PosePrior* prior) {
  BodyFitOptions options;
  options.marker_radius_m = marker_radius_m_;
  options.marker_sd_m = shaped.marker_sd_m;
  const auto fit = fit_body_pose(shaped.markers_in_shape, views_, start, prior, options, outlier_);
  if (fit) body.fit = *fit;
  return fit.has_value();
}

// The marker whose sample fits the pose worst, if it cannot be that marker.
std::uint32_t BodyFitter::worst_marker(const ShapedBody& shaped, const BodyState& body,
                                       const SampleIndex& index) const {
  std::uint32_t worst = kNoSample;
  double limit = kSampleChi2;
  for (std::uint32_t m = 0; m < shaped.markers_in_shape.size(); ++m) {
    if (body.sample[m] == kNoSample) continue;
    const MarkerSample& sample = index.samples()[body.sample[m]];
    const Eigen::Matrix3d spread =
        sample.covariance_m2 + point_covariance(body.fit.world_from_body, body.fit.covariance,
                                                shaped.markers_in_shape[m], shaped.marker_sd_m);
    const Eigen::Vector3d r =
        sample.position_in_world - body.fit.world_from_body * shaped.markers_in_shape[m];
    double chi2 = r.dot(spread.inverse() * r);
    // A sample of which the fit believes no view is no marker of this body, wherever its position is.
    bool believed = false;
    for (std::size_t k = 0; k < views_.size(); ++k)
      believed = believed || (views_[k].marker == m && outlier_[k] == 0);
    if (!believed) chi2 = std::max(chi2, 1e6);
    if (!(chi2 <= limit)) {
      limit = chi2;
      worst = m;
    }
  }
  return worst;
}

// The markers moved as one, though not as predicted: none of them but at most one is where it was expected.
// Else some tracks went astray, and what they make together with the others is no pose of this body.
bool BodyFitter::fit_jump(const ShapedBody& shaped, BodyState& body, const SampleIndex& index) {
  const std::size_t all = shaped.markers_in_shape.size();
  if (body.markers < std::max<std::size_t>(3, all / 2 + 1)) return false;
  std::array<Eigen::Vector3d, kBodyMarkers> in_world, in_shape;
  std::size_t n = 0, as_expected = 0;
  const Matrix6 covariance = body.motion.pose_covariance();
  for (std::size_t m = 0; m < all; ++m) {
    if (body.sample[m] == kNoSample) continue;
    const MarkerSample& sample = index.samples()[body.sample[m]];
    const Eigen::Matrix3d spread =
        sample.covariance_m2 +
        point_covariance(body.motion.pose(), covariance, shaped.markers_in_shape[m], shaped.marker_sd_m);
    const Eigen::Vector3d r = sample.position_in_world - body.motion.pose() * shaped.markers_in_shape[m];
    if (r.dot(spread.inverse() * r) <= kSampleChi2 && ++as_expected > 1) return false;
    in_world[n] = index.samples()[body.sample[m]].position_in_world;
    in_shape[n++] = shaped.markers_in_shape[m];
  }
  const auto start = pose_from_points({in_shape.data(), n}, {in_world.data(), n});
  return start && try_fit(shaped, body, *start, nullptr) && worst_marker(shaped, body, index) == kNoSample;
}

void BodyFitter::fit(const ShapedBody& shaped, BodyState& body, SampleIndex& index, BodyCounters& counters) {
  body.fitted = body.jumped = false;
  const PosePrior prior{body.motion.pose(), body.motion.pose_covariance()};
  bool jump_tried = false;
  for (;;) {
    collect(shaped, body, index);
    if (body.markers == 0) return;
    const bool done = try_fit(shaped, body, prior.world_from_body, &prior);
    // Most views refused: then it may be the prediction that is wrong.
    const bool refused = done && body.fit.outliers > body.fit.views;
    if (!jump_tried && (!done || refused || body.fit.prior_chi2 > kPoseChi2)) {
      jump_tried = true;
      if (fit_jump(shaped, body, index)) {
        body.fitted = body.jumped = true;
        return;
      }
      collect(shaped, body, index);
      if (!try_fit(shaped, body, prior.world_from_body, &prior))
        body.fit.world_from_body = prior.world_from_body;
    }
    std::uint32_t worst = worst_marker(shaped, body, index);
    if (worst == kNoSample && done && body.fit.prior_chi2 <= kPoseChi2) {
      body.fitted = true;
      return;
    }
    if (worst == kNoSample) {  // all agree with each other, but not with where the body can be
      double farthest = -1.0;
      for (std::uint32_t m = 0; m < shaped.markers_in_shape.size(); ++m) {
        if (body.sample[m] == kNoSample) continue;
        const double d = (index.samples()[body.sample[m]].position_in_world -
                          prior.world_from_body * shaped.markers_in_shape[m])
                             .norm();
        if (!(d <= farthest)) {
          farthest = d;
          worst = m;
        }
      }
    }
    index.use(body.sample[worst], false);
    body.sample[worst] = kNoSample;
    body.track[worst] = TrackId{};
    ++counters.let_go;
  }
}

bool BodyFitter::fit_alone(const ShapedBody& shaped, BodyState& body, const SampleIndex& index,
                           const Pose& start) {
  collect(shaped, body, index);
  body.fitted = try_fit(shaped, body, start, nullptr) && worst_marker(shaped, body, index) == kNoSample;
  return body.fitted;
}

}  // namespace glint
