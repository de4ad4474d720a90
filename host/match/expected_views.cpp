// SPDX-License-Identifier: MIT
// Projection of predictions with their uncertainty.
#include "host/match/expected_views.hpp"

#include <algorithm>
#include <cmath>

#include "host/geometry/spread.hpp"
#include "host/geometry/triangulate.hpp"

namespace glint {
namespace {

constexpr std::size_t kReserved = 512;  // tracks

}  // namespace

double ExpectedView::reach_px(double blob_px, double chi2) const noexcept {
  return blob_px + std::sqrt(chi2 * std::max(0.0, largest_variance(spread_px2)));
}

ExpectedViews::ExpectedViews(std::span<const Camera> cameras, const MatchOptions& options,
                             const BlobTable& table)
    : cameras_(cameras), options_(options), table_(table) {
  views_.reserve(kReserved * cameras.size());
}

void ExpectedViews::fill(std::span<const Prediction> predictions) {
  views_.clear();
  for (const Prediction& prediction : predictions)
    for (std::size_t camera = 0; camera < cameras_.size(); ++camera)
      views_.push_back(at(prediction, camera, prediction.position_in_world, prediction.covariance_m2));
}

ExpectedView ExpectedViews::at(const Prediction& prediction, std::size_t camera,
                               const Eigen::Vector3d& position_in_world,
                               const Eigen::Matrix3d& covariance_m2) const noexcept {
  ExpectedView view;
  view.in_front = project_outline(cameras_[camera], position_in_world, options_.marker_radius_m, view.pixel,
                                  view.by_position);
  if (!view.in_front) return view;
  if (camera < prediction.bias.size()) {
    view.bias_px = prediction.bias[camera].px;
    view.pixel += view.bias_px;
    view.beyond_calibration_px2 =
        prediction.bias[camera].variance_px2 - table_.calibration_variance_px2(camera);
  }
  view.spread_px2.noalias() = view.by_position * covariance_m2 * view.by_position.transpose();
  view.spread_px2.diagonal().array() += view.beyond_calibration_px2;
  return view;
}

}  // namespace glint
