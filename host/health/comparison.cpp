// SPDX-License-Identifier: MIT
// Leave-one-out points and the blobs around their images.
#include "host/health/comparison.hpp"

#include <algorithm>
#include <cmath>

#include <Eigen/Geometry>

#include "host/geometry/sphere_bias.hpp"
#include "host/geometry/triangulate.hpp"
#include "host/match/visible_volume.hpp"

namespace glint::health {
namespace {

// More views make the point hardly better and cost time.
constexpr std::size_t kMostViews = 4;
constexpr double kFar_m = 1e6;
constexpr std::uint32_t kUnusable = shaders::kBlobNotInvertible | shaders::kBlobOnBorder;

/// Median of chi-square, by Wilson and Hilferty's cube-root approximation.
double median_chi2(double degrees_of_freedom) noexcept {
  return degrees_of_freedom * std::pow(1.0 - 2.0 / (9.0 * degrees_of_freedom), 3);
}

// What any camera's centroids may err by, per axis, bright or dim, before one asks why.
constexpr double kCentroid_px = 0.05;

}  // namespace

ComparedCamera::ComparedCamera(const CameraCalibration& calibration, const MatchOptions& options)
    : camera_(calibration),
      // rms_px counts the length of the residual, two axes together.
      variance_px2_(std::max(options.sigma_px * options.sigma_px, kCentroid_px * kCentroid_px) +
                    calibration.rms_px * calibration.rms_px / 2.0),
      focal_px_(std::min(std::abs(calibration.fx_px), std::abs(calibration.fy_px))),
      marker_radius_m_(options.marker_radius_m) {}

std::optional<Comparison> ComparedCamera::compare(const OthersPoint& point,
                                                  const Eigen::Vector3d& velocity_in_world,
                                                  std::span<const shaders::BlobRecord> blobs) const noexcept {
  const CameraCalibration& c = camera_.calibration();
  Eigen::Vector2d pixel;
  Eigen::Matrix<double, 2, 3> jacobian;
  if (!sees(camera_, point.position_in_world, 0.0, 0.0, kFar_m) ||
      !project_pinhole(camera_, point.position_in_world, pixel, jacobian))
    return std::nullopt;
  const double depth_m = camera_.in_camera(point.position_in_world).z();
  const Eigen::Vector2d centre(c.cx_px, c.cy_px);
  pixel = centre + sphere_bias_factor(marker_radius_m_, depth_m) * (pixel - centre);

  Comparison result;
  const double reach_px = kReach_rad * focal_px_;
  std::array<double, Comparison::kBlobs> distance2;
  for (const shaders::BlobRecord& blob : blobs) {
    if ((blob.flags & kUnusable) != 0) continue;
    const Eigen::Vector2d offset(c.fx_px * static_cast<double>(blob.x_undist) + c.cx_px - pixel.x(),
                                 c.fy_px * static_cast<double>(blob.y_undist) + c.cy_px - pixel.y());
    const double d2 = offset.squaredNorm();
    if (!(d2 <= reach_px * reach_px)) continue;
    std::size_t place = result.blobs;
    while (place > 0 && distance2[place - 1] > d2) --place;
    if (place == Comparison::kBlobs) continue;
    result.blobs = static_cast<std::uint8_t>(std::min<std::size_t>(result.blobs + 1u, Comparison::kBlobs));
    for (std::size_t k = result.blobs - 1u; k > place; --k) {
      distance2[k] = distance2[k - 1];
      result.offset_px[k] = result.offset_px[k - 1];
    }
    distance2[place] = d2;
    result.offset_px[place] = offset;
  }

  result.at = {(pixel.x() - c.cx_px) / c.fx_px, (pixel.y() - c.cy_px) / c.fy_px};
  result.velocity_px_s = jacobian * velocity_in_world;
  result.covariance_px2 =
      jacobian * point.covariance_m2 * jacobian.transpose() + variance_px2_ * Eigen::Matrix2d::Identity();
  result.px_per_m = focal_px_ / depth_m;
  result.clutter_per_px2 =
      static_cast<double>(blobs.size()) / std::max(1.0, static_cast<double>(c.width_px) * c.height_px);
  result.chi2_ratio = point.chi2_ratio;
  const double cell_px = std::max(1.0, c.width_px / static_cast<double>(kCellsAcross));
  const auto cell_of = [cell_px](double at_px, std::uint32_t size_px) {
    return static_cast<unsigned>(std::clamp(at_px, 0.0, size_px - 1.0) / cell_px);
  };
  result.cell = static_cast<std::uint16_t>(cell_of(pixel.y(), c.height_px) * kCellsAcross +
                                           std::min(cell_of(pixel.x(), c.width_px), kCellsAcross - 1));
  return result;
}

std::optional<OthersPoint> point_of_others(const Point& point, std::uint32_t allowed,
                                           std::span<const ComparedCamera> cameras,
                                           std::span<const std::span<const shaders::BlobRecord>> blobs,
                                           double marker_radius_m) noexcept {
  std::array<Observation, kMostViews> views;
  std::size_t count = 0;
  for (std::size_t c = 0; c < cameras.size() && count < kMostViews; ++c) {
    if ((allowed >> c & 1u) == 0 || point.blob_of_camera[c] < 0) continue;
    if ((point.resolved >> c & 1u) != 0)
      continue;  // more, or less, than this marker: its centroid is elsewhere
    const shaders::BlobRecord& blob = blobs[c][static_cast<std::size_t>(point.blob_of_camera[c])];
    if ((blob.flags & kUnusable) != 0) continue;
    Observation& view = views[count++];
    view.camera = &cameras[c].camera();
    view.normalized = {static_cast<double>(blob.x_undist), static_cast<double>(blob.y_undist)};
    view.covariance_px2 = cameras[c].variance_px2() * Eigen::Matrix2d::Identity();
  }
  if (count < 2) return std::nullopt;
  TriangulateOptions options;
  options.marker_radius_m = marker_radius_m;
  const auto made = triangulate(std::span<const Observation>(views.data(), count), options);
  if (!made) return std::nullopt;
  OthersPoint result;
  result.position_in_world = made->position_in_world;
  result.covariance_m2 = made->covariance_m2;
  result.chi2_ratio = made->chi2 / median_chi2(2.0 * static_cast<double>(count) - 3.0);
  return result;
}

void ComparisonWindow::add(const Comparison& comparison) noexcept {
  if (count_ == kCapacity) {
    first_ = (first_ + 1) % kCapacity;
    --count_;
  }
  ring_[(first_ + count_) % kCapacity] = comparison;
  ++count_;
}

void ComparisonWindow::forget_before(double time_s) noexcept {
  while (count_ > 0 && ring_[first_].time_s < time_s) {
    first_ = (first_ + 1) % kCapacity;
    --count_;
  }
}

}  // namespace glint::health
