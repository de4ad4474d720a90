// SPDX-License-Identifier: MIT
// Where each camera should show each track's marker.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include <Eigen/Core>

#include "host/geometry/camera.hpp"
#include "host/match/blob_table.hpp"
#include "host/match/prediction.hpp"

namespace glint {

/// Where one camera expects the blob of a marker. Undistorted pixels.
struct ExpectedView {
  Eigen::Vector2d pixel;  ///< the track's bias included
  Eigen::Matrix<double, 2, 3> by_position;
  Eigen::Matrix2d
      spread_px2;  ///< of the position, and of the bias beyond what every blob's covariance holds of it
  Eigen::Vector2d bias_px = Eigen::Vector2d::Zero();
  double beyond_calibration_px2 = 0.0;  ///< that share: negative where the track knows its bias
  bool in_front = false;                ///< false: nothing else is valid

  /// Covariance of where a blob lies, off from `pixel`.
  Eigen::Matrix2d with(const MatchBlob& blob) const noexcept { return spread_px2 + blob.covariance_px2; }
  /// Every blob with a squared Mahalanobis distance below `chi2` lies within this, if its own error is at
  /// most `blob_px`.
  double reach_px(double blob_px, double chi2) const noexcept;
};

/// Computed once for an exposure, since all who look for a track's blobs begin with it. Keeps its memory.
class ExpectedViews {
 public:
  /// Borrowed for the life of this.
  ExpectedViews(std::span<const Camera> cameras, const MatchOptions& options, const BlobTable& table);

  void fill(std::span<const Prediction> predictions);
  const ExpectedView& of(std::size_t prediction, std::size_t camera) const noexcept {
    return views_[prediction * cameras_.size() + camera];
  }
  /// The same for another position of that track's marker.
  ExpectedView at(const Prediction& prediction, std::size_t camera, const Eigen::Vector3d& position_in_world,
                  const Eigen::Matrix3d& covariance_m2) const noexcept;

 private:
  std::span<const Camera> cameras_;
  const MatchOptions& options_;
  const BlobTable& table_;
  std::vector<ExpectedView> views_;  // [prediction][camera]
};

}  // namespace glint
