// SPDX-License-Identifier: MIT
// Where a camera's blobs lie against where the other cameras' points should appear in it.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include <Eigen/Core>

#include "host/geometry/camera.hpp"
#include "host/match/matcher.hpp"

namespace glint::health {

/// A point that does not owe anything to the camera it is to be compared with.
struct OthersPoint {
  Eigen::Vector3d position_in_world = Eigen::Vector3d::Zero();
  Eigen::Matrix3d covariance_m2 = Eigen::Matrix3d::Zero();
  double chi2_ratio = 0.0;  ///< how badly its own cameras agree on it: chi2 over its median
};

/// One point of the others and the blobs of a camera that may be its image; none if none is near. Offsets are
/// measured minus predicted, undistorted pixels.
struct Comparison {
  static constexpr std::size_t kBlobs = 4;
  double time_s = 0.0;
  Eigen::Vector2d at = Eigen::Vector2d::Zero();             ///< predicted, z = 1 plane
  Eigen::Vector2d velocity_px_s = Eigen::Vector2d::Zero();  ///< of the predicted image
  Eigen::Matrix2d covariance_px2 =
      Eigen::Matrix2d::Identity();  ///< of the right blob's offset if all is well
  double px_per_m = 0.0;            ///< at the point's distance
  double clutter_per_px2 = 0.0;     ///< blobs of the camera over its area
  double chi2_ratio = 0.0;          ///< of the point
  std::uint16_t cell = 0;           ///< which part of the image
  std::uint8_t blobs = 0;
  std::array<Eigen::Vector2d, kBlobs> offset_px;  ///< of the nearest blobs, nearest first
};

/// How far around a predicted place blobs are looked at, as an angle: more than any knock that leaves a
/// camera pointing at the volume.
inline constexpr double kReach_rad = 0.12;
/// An image is divided into so many parts along its width.
inline constexpr unsigned kCellsAcross = 32;

/// Ready-made constants of a camera.
class ComparedCamera {
 public:
  ComparedCamera(const CameraCalibration& calibration, const MatchOptions& options);

  const Camera& camera() const noexcept { return camera_; }
  double variance_px2() const noexcept { return variance_px2_; }  ///< per axis, of a blob
  double focal_px() const noexcept { return focal_px_; }

  /// Nothing if the camera cannot see the point.
  std::optional<Comparison> compare(const OthersPoint& point, const Eigen::Vector3d& velocity_in_world,
                                    std::span<const shaders::BlobRecord> blobs) const noexcept;

 private:
  Camera camera_;
  double variance_px2_, focal_px_, marker_radius_m_;
};

/// The point by the views that are in `allowed` (bit set of cameras); nothing if they are too few.
std::optional<OthersPoint> point_of_others(const Point& point, std::uint32_t allowed,
                                           std::span<const ComparedCamera> cameras,
                                           std::span<const std::span<const shaders::BlobRecord>> blobs,
                                           double marker_radius_m) noexcept;

/// The last comparisons of one camera.
class ComparisonWindow {
 public:
  static constexpr std::size_t kCapacity = 256;
  ComparisonWindow() : ring_(kCapacity) {}

  void add(const Comparison& comparison) noexcept;
  void forget_before(double time_s) noexcept;
  void clear() noexcept { count_ = 0; }
  std::size_t size() const noexcept { return count_; }
  /// 0 is the oldest.
  const Comparison& operator[](std::size_t n) const noexcept { return ring_[(first_ + n) % kCapacity]; }

 private:
  std::vector<Comparison> ring_;
  std::size_t first_ = 0, count_ = 0;
};

}  // namespace glint::health
