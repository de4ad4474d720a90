// SPDX-License-Identifier: MIT
// The blobs of one exposure as the matcher wants them: rays, covariances, and a grid over each camera's
// image.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include <Eigen/Core>

#include "gpu/lens.hpp"
#include "host/geometry/camera.hpp"
#include "host/match/matcher.hpp"
#include "host/match/noise_factor.hpp"
#include "host/resolve/pixel_noise.hpp"

namespace glint {

/// One blob, ready for geometry.
struct MatchBlob {
  Eigen::Vector2d normalized;          ///< z = 1 plane
  Eigen::Vector2d pixel;               ///< undistorted pixel
  Eigen::Vector3d direction_in_world;  ///< unit vector
  Eigen::Matrix2d covariance_px2;      ///< of the centroid, undistorted pixels
  double sigma_px;                     ///< the larger standard deviation
  double angle_per_px;                 ///< radians that one pixel subtends here, at most
  double radius_px;                    ///< of a disc of the same area; 0: area unknown
  std::uint32_t camera;
  std::uint32_t record;  ///< index into the camera's blobs as they were detected; several blobs may share one
  bool usable;           ///< the lens model can be inverted here
  bool elongated;        ///< longer than one marker looks
  bool suspect;          ///< that, or cut off by the border, hidden in part, or explained by another point
  bool saturated;
  float light;    ///< brightness of its marker, in units of what is usual for the camera; 0: not known
  bool fitted;    ///< placed by its pixels, one marker or not
  bool resolved;  ///< placed by its pixels because its centroid is not one marker's; then radius_px is 0
};

/// Fills itself from detector records; blobs of all cameras are numbered through, camera by camera. Keeps its
/// memory.
class BlobTable {
 public:
  /// `cameras` is borrowed for the life of the table.
  BlobTable(std::span<const Camera> cameras, const MatchOptions& options);

  void fill(std::span<const std::span<const shaders::BlobRecord>> blobs);

  /// What a closer look makes of a blob, for settle(): the first for a blob replaces it, further ones of the
  /// same are new blobs beside it. `centre` in the z = 1 plane; the covariance is the blob's own, in
  /// undistorted pixels. `light`: see MatchBlob. `partial`: something may hide some of the marker.
  void resolve(std::uint32_t blob, const Eigen::Vector2d& centre, const Eigen::Matrix2d& covariance_px2,
               double light, bool partial);
  /// The blob is the whole image of one marker: its size says nothing more.
  void whole(std::uint32_t blob, double light) noexcept {
    blobs_[blob].radius_px = 0.0;
    blobs_[blob].light = static_cast<float>(light);
  }
  /// Nothing explains the blob: its centroid may be off by a good part of the marker's radius.
  void doubt(std::uint32_t blob, double radius_px) noexcept;
  /// Puts what was resolved in its place. Numbers of blobs change.
  void settle();

  std::size_t size() const noexcept { return blobs_.size(); }
  std::size_t cameras() const noexcept { return cameras_.size(); }
  std::uint32_t begin_of(std::size_t camera) const noexcept { return begin_[camera]; }
  std::uint32_t end_of(std::size_t camera) const noexcept { return begin_[camera + 1]; }
  const MatchBlob& operator[](std::uint32_t blob) const noexcept { return blobs_[blob]; }

  bool free(std::uint32_t blob) const noexcept { return free_[blob] != 0; }
  void claim(std::uint32_t blob) noexcept { free_[blob] = 0; }
  /// From now on `blob` counts as possibly more, or less, than one marker.
  void suspect(std::uint32_t blob) noexcept { blobs_[blob].suspect = true; }
  std::size_t free_blobs(std::size_t camera) const noexcept;
  /// The part of a blob's variance, per axis, that is the calibration's and not its own.
  double calibration_variance_px2(std::size_t camera) const noexcept {
    return calibration_variance_px2_[camera];
  }
  /// What a residual teaches of blobs of this kind and camera, see NoiseFactor; misfit: over the blob's own
  /// variance without match.sigma_px, which no factor changes.
  void learn_noise(std::uint32_t blob, double misfit, double freedom) noexcept {
    NoiseFactor& factor = factor_of(blobs_[blob]);
    factor.learn(misfit * factor.value(), freedom);
  }
  /// What a camera's pixels err by; at first what is assumed of a raw 8-bit camera. From the next fill() on.
  void set_noise(std::size_t camera, const PixelNoise& noise) noexcept { noise_[camera] = noise; }
  /// Largest residual of a blob that may belong to a point, the calibration's errors included.
  double gate_px(std::size_t camera) const noexcept { return gate_px_[camera]; }

  /// Calls visit(blob) for every free, usable blob within `radius_px` of an undistorted pixel.
  template <typename Visit>
  void near(std::size_t camera, const Eigen::Vector2d& pixel, double radius_px, Visit&& visit) const {
    const Grid& grid = grids_[camera];
    if (grid.empty() || !(radius_px >= 0.0)) return;
    const auto [c0, c1] = grid.columns_between(pixel.x() - radius_px, pixel.x() + radius_px);
    const auto [r0, r1] = grid.rows_between(pixel.y() - radius_px, pixel.y() + radius_px);
    for (int r = r0; r <= r1; ++r)
      visit_cells(grid, r, c0, c1, [&](std::uint32_t blob) {
        if ((blobs_[blob].pixel - pixel).squaredNorm() <= radius_px * radius_px) visit(blob);
      });
  }

  struct Grid {
    double x0 = 0, y0 = 0, x1 = 0, y1 = 0, cell_px = 1;  ///< bounding box of the blobs
    int columns = 0, rows = 0;
    std::vector<std::uint32_t> first, blobs;  ///< row by row
    bool empty() const noexcept { return blobs.empty(); }
    /// Cells from low to high, clipped to the grid; low > high where there is none.
    std::pair<int, int> columns_between(double low_px, double high_px) const noexcept;
    std::pair<int, int> rows_between(double low_px, double high_px) const noexcept;
  };
  const Grid& grid(std::size_t camera) const noexcept { return grids_[camera]; }
  /// Calls visit(blob) for every free blob in the cells of one row.
  template <typename Visit>
  void visit_cells(const Grid& grid, int row, int column0, int column1, Visit&& visit) const {
    if (column0 > column1) return;
    const auto base = static_cast<std::size_t>(row) * static_cast<std::size_t>(grid.columns);
    const std::uint32_t begin = grid.first[base + static_cast<std::size_t>(column0)];
    const std::uint32_t end = grid.first[base + static_cast<std::size_t>(column1) + 1];
    for (std::uint32_t k = begin; k < end; ++k)
      if (free(grid.blobs[k])) visit(grid.blobs[k]);
  }

 private:
  void build_grid(std::size_t camera);
  void finish();
  void place(MatchBlob& blob, const Eigen::Vector2d& normalized) const noexcept;
  Eigen::Matrix2d own_covariance(const shaders::BlobRecord& record, const MatchBlob& blob) const noexcept;

  std::span<const Camera> cameras_;
  const MatchOptions& options_;
  std::vector<double> calibration_variance_px2_, gate_px_;
  std::vector<PixelNoise> noise_;
  // Centroids and fits err by different laws.
  struct Factors {
    NoiseFactor centroid, fit;
  };
  std::vector<Factors> factors_;
  NoiseFactor& factor_of(const MatchBlob& blob) noexcept {
    return blob.fitted ? factors_[blob.camera].fit : factors_[blob.camera].centroid;
  }
  struct Resolved {
    std::uint32_t blob;
    Eigen::Vector2d centre;
    Eigen::Matrix2d covariance_px2;
    double light;
    bool partial;
  };
  std::vector<gpu::Lens> lenses_;
  std::vector<MatchBlob> blobs_, settled_;
  std::vector<Resolved> resolved_;
  std::vector<std::uint8_t> free_;
  std::vector<std::uint32_t> begin_;
  std::vector<Grid> grids_;
};

}  // namespace glint
