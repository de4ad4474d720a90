// SPDX-License-Identifier: MIT
// From detector records to rays with covariances.
#include "host/match/blob_table.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "gpu/lens_model.hpp"
#include "host/base/check.hpp"
#include "host/geometry/spread.hpp"
#include "host/resolve/centroid_noise.hpp"

namespace glint {
namespace {

// Of two merged discs of equal weight the centroid lies sqrt(l1 - l2) from either centre, l1 >= l2 being the
// eigenvalues of the second moments; so that is the standard deviation along the long axis of a blob which
// one marker does not explain. Small blobs have ragged moments (a 3x2 block: 0.67 and 0.25 px^2) and motion
// blur of L pixels adds L^2/12 to l1; both stay below these limits up to L = 3.
constexpr double kElongationRatio = 1.6;
constexpr double kElongationOffsetPx2 = 0.5;
constexpr std::uint32_t kMomentsAreaPx = 4;  // fewer pixels say nothing about shape
// A blob that the border cuts loses an unknown part: its centroid is off by up to about half its radius.
constexpr double kBorderOffsetOfRadius = 0.5;
// The flat top of a clipped profile carries no position; the flanks give about half the precision.
constexpr double kSaturatedFactor = 2.0;

// A blob of which nothing but its place is known.
constexpr double kUnknownSigma_px = 0.05;
// Errors of the calibration in multiples of its rms: lengths of two normal errors together exceed 3.5 once in
// 200,000.
constexpr double kCalibrationGate = 3.5;

int clamp_cell(double value, int cells) noexcept {
  return static_cast<int>(std::clamp(std::floor(value), 0.0, static_cast<double>(cells - 1)));
}

std::pair<int, int> cells_between(double low, double high, double begin, double end, double cell_px,
                                  int cells) noexcept {
  if (!(low <= end) || !(high >= begin)) return {0, -1};
  return {clamp_cell((low - begin) / cell_px, cells), clamp_cell((high - begin) / cell_px, cells)};
}

}  // namespace

std::pair<int, int> BlobTable::Grid::columns_between(double low_px, double high_px) const noexcept {
  return cells_between(low_px, high_px, x0, x1, cell_px, columns);
}

std::pair<int, int> BlobTable::Grid::rows_between(double low_px, double high_px) const noexcept {
  return cells_between(low_px, high_px, y0, y1, cell_px, rows);
}

BlobTable::BlobTable(std::span<const Camera> cameras, const MatchOptions& options)
    : cameras_(cameras), options_(options), begin_(cameras.size() + 1, 0), grids_(cameras.size()) {
  noise_.resize(cameras.size());
  factors_.resize(cameras.size());
  for (const Camera& camera : cameras) {
    const double calibration_px = camera.calibration().rms_px;
    const CameraCalibration& c = camera.calibration();
    lenses_.push_back({c.fx_px, c.fy_px, c.cx_px, c.cy_px, c.k1_k2_p1_p2_k3});
    calibration_variance_px2_.push_back(calibration_px * calibration_px / 2.0);
    gate_px_.push_back(std::hypot(options.gate_px, kCalibrationGate * calibration_px));
  }
}

void BlobTable::fill(std::span<const std::span<const shaders::BlobRecord>> blobs) {
  GLINT_CHECK(blobs.size() == cameras_.size());
  blobs_.clear();
  for (std::size_t camera = 0; camera < cameras_.size(); ++camera) {
    begin_[camera] = static_cast<std::uint32_t>(blobs_.size());
    for (std::uint32_t number = 0; number < blobs[camera].size(); ++number) {
      const shaders::BlobRecord& record = blobs[camera][number];
      MatchBlob& blob = blobs_.emplace_back();
      blob.camera = static_cast<std::uint32_t>(camera);
      blob.record = number;
      blob.radius_px = std::sqrt(static_cast<double>(record.area_px) / std::numbers::pi);
      place(blob, {static_cast<double>(record.x_undist), static_cast<double>(record.y_undist)});
      blob.usable = (record.flags & shaders::kBlobNotInvertible) == 0 && blob.pixel.allFinite();
      blob.suspect = blob.elongated = false;
      blob.saturated = (record.flags & shaders::kBlobSaturated) != 0;
      blob.fitted = blob.resolved = false;
      blob.light = 0.0f;

      blob.covariance_px2 = own_covariance(record, blob);
      blob.covariance_px2.diagonal().array() += calibration_variance_px2_[camera];
      if ((record.flags & shaders::kBlobOnBorder) != 0) {
        blob.covariance_px2.diagonal().array() +=
            std::pow(kBorderOffsetOfRadius * std::max(blob.radius_px, 1.0), 2);
        blob.suspect = true;
      }
      const double xx = static_cast<double>(record.var_xx_px2), xy = static_cast<double>(record.var_xy_px2),
                   yy = static_cast<double>(record.var_yy_px2);
      const double half_difference = std::hypot((xx - yy) / 2.0, xy), mean = (xx + yy) / 2.0;
      const double l1 = mean + half_difference, l2 = std::max(mean - half_difference, 0.0);
      if (record.area_px >= kMomentsAreaPx && l1 > kElongationRatio * l2 + kElongationOffsetPx2) {
        // The moments are of the raw image; the lens turns the axis too little to matter for a weight.
        const double angle = 0.5 * std::atan2(2.0 * xy, xx - yy);
        const Eigen::Vector2d axis(std::cos(angle), std::sin(angle));
        blob.covariance_px2 += (l1 - l2) * axis * axis.transpose();
        blob.suspect = blob.elongated = true;
      }
      blob.sigma_px = largest_sigma(blob.covariance_px2);
    }
  }
  resolved_.clear();
  finish();
}

void BlobTable::place(MatchBlob& blob, const Eigen::Vector2d& normalized) const noexcept {
  const CameraCalibration& c = cameras_[blob.camera].calibration();
  const double focal_px = std::min(std::abs(c.fx_px), std::abs(c.fy_px));
  blob.normalized = normalized;
  blob.pixel = {c.fx_px * normalized.x() + c.cx_px, c.fy_px * normalized.y() + c.cy_px};
  blob.direction_in_world = cameras_[blob.camera].direction_in_world(normalized);
  blob.angle_per_px = 1.0 / (focal_px * std::sqrt(1.0 + normalized.squaredNorm()));
}

// Without the calibration's share.
Eigen::Matrix2d BlobTable::own_covariance(const shaders::BlobRecord& record,
                                          const MatchBlob& blob) const noexcept {
  Eigen::Matrix2d covariance = options_.sigma_px * options_.sigma_px * Eigen::Matrix2d::Identity();
  const double factor = factors_[blob.camera].centroid.value();
  if (record.weight == 0) {
    const double sigma_px = kUnknownSigma_px * (blob.saturated ? kSaturatedFactor : 1.0);
    covariance.diagonal().array() += factor * sigma_px * sigma_px;
    return covariance;
  }
  // The lens magnifies: so many undistorted pixels is one of the image, and so much more is its noise.
  const gpu::Forward lens = gpu::forward(lenses_[blob.camera], blob.normalized.x(), blob.normalized.y());
  if (!lens.positive_definite()) return covariance;
  Eigen::Matrix2d distort;
  distort << lens.xx, lens.xy, lens.xy, lens.yy;
  const Eigen::Matrix2d undistort = distort.inverse();
  return covariance +
         factor * undistort * centroid_covariance_px2(record, noise_[blob.camera]) * undistort.transpose();
}

void BlobTable::resolve(std::uint32_t blob, const Eigen::Vector2d& centre,
                        const Eigen::Matrix2d& covariance_px2, double light, bool partial) {
  resolved_.push_back({blob, centre, covariance_px2, light, partial});
}

void BlobTable::doubt(std::uint32_t blob, double radius_px) noexcept {
  MatchBlob& b = blobs_[blob];
  b.covariance_px2.diagonal().array() +=
      std::pow(kBorderOffsetOfRadius * std::max(b.radius_px, radius_px), 2);
  b.sigma_px = largest_sigma(b.covariance_px2);
  b.suspect = true;
}

void BlobTable::settle() {
  if (resolved_.empty()) return;
  std::sort(resolved_.begin(), resolved_.end(),
            [](const Resolved& a, const Resolved& b) { return a.blob < b.blob; });
  settled_.clear();
  std::size_t next = 0;
  for (std::size_t camera = 0; camera < cameras_.size(); ++camera) {
    const std::uint32_t begin = static_cast<std::uint32_t>(settled_.size());
    for (std::uint32_t blob = begin_[camera]; blob < begin_[camera + 1]; ++blob) {
      if (next == resolved_.size() || resolved_[next].blob != blob) {
        settled_.push_back(blobs_[blob]);
        continue;
      }
      for (; next < resolved_.size() && resolved_[next].blob == blob; ++next) {
        MatchBlob& part = settled_.emplace_back(blobs_[blob]);
        place(part, resolved_[next].centre);
        part.fitted = true;
        part.covariance_px2 = factors_[camera].fit.value() * resolved_[next].covariance_px2;
        part.covariance_px2.diagonal().array() +=
            options_.sigma_px * options_.sigma_px + calibration_variance_px2_[camera];
        part.sigma_px = largest_sigma(part.covariance_px2);
        part.suspect = resolved_[next].partial;
        part.light = static_cast<float>(resolved_[next].light);
        part.elongated = part.saturated = false;
        part.resolved = part.radius_px != 0.0;  // of whole() it is 0: then the centroid was right, too
        part.radius_px = 0.0;
      }
    }
    begin_[camera] = begin;
  }
  resolved_.clear();
  blobs_.swap(settled_);
  finish();
}

// Everything that depends on all blobs being there.
void BlobTable::finish() {
  begin_.back() = static_cast<std::uint32_t>(blobs_.size());
  free_.assign(blobs_.size(), 1);
  for (std::uint32_t blob = 0; blob < blobs_.size(); ++blob)
    if (!blobs_[blob].usable) claim(blob);
  for (std::size_t camera = 0; camera < cameras_.size(); ++camera) build_grid(camera);
}

std::size_t BlobTable::free_blobs(std::size_t camera) const noexcept {
  return static_cast<std::size_t>(
      std::count(free_.begin() + begin_[camera], free_.begin() + begin_[camera + 1], 1));
}

void BlobTable::build_grid(std::size_t camera) {
  Grid& grid = grids_[camera];
  grid.blobs.clear();
  Eigen::Vector2d low = Eigen::Vector2d::Constant(1e300), high = -low;
  std::size_t count = 0;
  for (std::uint32_t blob = begin_[camera]; blob < begin_[camera + 1]; ++blob) {
    if (!free(blob)) continue;
    low = low.cwiseMin(blobs_[blob].pixel);
    high = high.cwiseMax(blobs_[blob].pixel);
    ++count;
  }
  if (count == 0) return;
  grid.x0 = low.x();
  grid.y0 = low.y();
  grid.x1 = high.x();
  grid.y1 = high.y();
  const double width = std::max(high.x() - low.x(), 1.0), height = std::max(high.y() - low.y(), 1.0);
  // About one blob per cell; a line of blobs must not make cells without end.
  grid.cell_px = std::max(std::sqrt(width * height / static_cast<double>(count)),
                          std::max(width, height) / (2.0 * static_cast<double>(count) + 2.0));
  grid.columns = static_cast<int>(width / grid.cell_px) + 1;
  grid.rows = static_cast<int>(height / grid.cell_px) + 1;
  const auto cells = static_cast<std::size_t>(grid.columns) * static_cast<std::size_t>(grid.rows);
  const auto cell_of = [&grid](const Eigen::Vector2d& pixel) {
    return static_cast<std::size_t>(clamp_cell((pixel.y() - grid.y0) / grid.cell_px, grid.rows)) *
               static_cast<std::size_t>(grid.columns) +
           static_cast<std::size_t>(clamp_cell((pixel.x() - grid.x0) / grid.cell_px, grid.columns));
  };
  grid.first.assign(cells + 2, 0);
  for (std::uint32_t blob = begin_[camera]; blob < begin_[camera + 1]; ++blob)
    if (free(blob)) ++grid.first[cell_of(blobs_[blob].pixel) + 2];
  for (std::size_t cell = 2; cell < cells + 2; ++cell) grid.first[cell] += grid.first[cell - 1];
  grid.blobs.resize(count);
  for (std::uint32_t blob = begin_[camera]; blob < begin_[camera + 1]; ++blob)
    if (free(blob)) grid.blobs[grid.first[cell_of(blobs_[blob].pixel) + 1]++] = blob;
}

}  // namespace glint
