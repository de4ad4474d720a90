// SPDX-License-Identifier: MIT
// Epipolar search with a grid.
#include "host/match/pair_search.hpp"

#include <algorithm>
#include <cmath>

#include <Eigen/Geometry>

#include "host/match/limits.hpp"

namespace glint {
namespace {

constexpr double kMinSine = 0.03;  // rays that meet below 1.7 degrees (or above 178.3) give no depth
constexpr double kCoarse = 1.5;    // the walk's tolerance, widened: meet() decides

/// The part of [low, high] in which value + s * slope >= limit.
void clip(double value, double slope, double limit, double& low, double& high) noexcept {
  if (std::abs(slope) < 1e-15) {
    if (value < limit) high = low - 1.0;
  } else if (const double s = (limit - value) / slope; slope > 0.0) {
    low = std::max(low, s);
  } else {
    high = std::min(high, s);
  }
}

}  // namespace

PairSearch::PairSearch(std::span<const Camera> cameras, const MatchOptions& options, const BlobTable& table)
    : cameras_(cameras), options_(options), table_(table) {}

std::optional<BlobPair> PairSearch::meet(std::uint32_t a, std::uint32_t b) const noexcept {
  const MatchBlob &p = table_[a], &q = table_[b];
  const Eigen::Vector3d &ca = cameras_[p.camera].position_in_world(),
                        &cb = cameras_[q.camera].position_in_world();
  const Eigen::Vector3d base = cb - ca;
  const Eigen::Vector3d normal = p.direction_in_world.cross(q.direction_in_world);
  const double sine2 = normal.squaredNorm();
  if (sine2 < kMinSine * kMinSine) return std::nullopt;
  const double range_a = base.cross(q.direction_in_world).dot(normal) / sine2;
  const double range_b = base.cross(p.direction_in_world).dot(normal) / sine2;
  if (range_a < options_.min_range_m || range_a > options_.max_range_m || range_b < options_.min_range_m ||
      range_b > options_.max_range_m)
    return std::nullopt;
  // What one pixel is at that range, and so the variance of the distance between the rays.
  const double metre_per_px_a = range_a * p.angle_per_px, metre_per_px_b = range_b * q.angle_per_px;
  double variance = std::pow(metre_per_px_a * p.sigma_px, 2) + std::pow(metre_per_px_b * q.sigma_px, 2);
  if (const double r2 = options_.marker_radius_m * options_.marker_radius_m; r2 > 0.0) {
    // The bias of the outline's centre, removed later, moves a ray by up to r^2 tan(t) / range.
    variance +=
        r2 * r2 *
        (p.normalized.squaredNorm() / (range_a * range_a) + q.normalized.squaredNorm() / (range_b * range_b));
  }
  const double skew = base.dot(normal), distance2 = skew * skew / sine2;
  if (distance2 > kPairChi2 * variance) return std::nullopt;
  const double gate = table_.gate_px(p.camera) * metre_per_px_a + table_.gate_px(q.camera) * metre_per_px_b;
  if (distance2 > gate * gate) return std::nullopt;
  BlobPair pair;
  pair.a = a;
  pair.b = b;
  pair.chi2 = distance2 / variance;
  pair.midpoint_in_world = 0.5 * (ca + range_a * p.direction_in_world + cb + range_b * q.direction_in_world);
  return pair;
}

void PairSearch::collect_along_line(std::uint32_t a, std::size_t camera) {
  const BlobTable::Grid& grid = table_.grid(camera);
  if (grid.empty()) return;
  const MatchBlob& blob = table_[a];
  const Camera &from = cameras_[blob.camera], &to = cameras_[camera];
  // The ray in the other camera's frame: origin + s * slope.
  const Eigen::Vector3d origin = to.in_camera(from.position_in_world());
  const Eigen::Vector3d slope = to.camera_from_world_rotation() * blob.direction_in_world;
  double s0 = options_.min_range_m, s1 = options_.max_range_m;
  clip(origin.z(), slope.z(), 0.05 * options_.min_range_m, s0, s1);
  if (!(s0 < s1)) return;
  const CameraCalibration& c = to.calibration();
  const auto pixel_at = [&](double s) {
    const Eigen::Vector3d p = origin + s * slope;
    return Eigen::Vector2d(c.fx_px * p.x() / p.z() + c.cx_px, c.fy_px * p.y() / p.z() + c.cy_px);
  };
  const double reach = std::sqrt(kPairChi2);
  // A blob of the other camera may be of the widest kind; the gate bounds how far it may lie off.
  const double own_px = std::min(table_.gate_px(blob.camera), reach * blob.sigma_px),
               other_px = table_.gate_px(camera);
  const double focal_px = std::max(std::abs(c.fx_px), std::abs(c.fy_px));
  const auto tolerance_at = [&](double s) {
    // One pixel off the ray, seen at this depth by the other camera, whose own obliqueness lengthens it.
    const Eigen::Vector3d p = origin + s * slope;
    return kCoarse * (other_px + own_px * s * blob.angle_per_px * focal_px * p.norm() / (p.z() * p.z()));
  };
  const Eigen::Vector2d e0 = pixel_at(s0), e1 = pixel_at(s1);
  const Eigen::Vector2d along = e1 - e0;
  if (!e0.allFinite() || !e1.allFinite()) return;
  const double length = along.norm();
  const double widest = std::min(std::max(tolerance_at(s0), tolerance_at(s1)),
                                 std::max(grid.x1 - grid.x0, grid.y1 - grid.y0) + grid.cell_px);
  if (length < widest) {  // the whole ray is one spot there
    table_.near(camera, 0.5 * (e0 + e1), 0.5 * length + widest,
                [this](std::uint32_t b) { candidates_.push_back(b); });
    return;
  }
  const Eigen::Vector2d across = Eigen::Vector2d(-along.y(), along.x()) / length;
  const double offset = across.dot(e0);

  // Clip to the blobs' bounding box, widened.
  double t0 = -widest / length, t1 = 1.0 + widest / length;
  clip(e0.x(), along.x(), grid.x0 - widest, t0, t1);
  clip(-e0.x(), -along.x(), -grid.x1 - widest, t0, t1);
  clip(e0.y(), along.y(), grid.y0 - widest, t0, t1);
  clip(-e0.y(), -along.y(), -grid.y1 - widest, t0, t1);
  if (!(t0 <= t1)) return;

  // Row by row where the line is steep, else column by column turned into rows: visit_cells() takes row
  // stretches, so that a line that runs along the rows needs few calls.
  const Eigen::Vector2d p0 = e0 + t0 * along, p1 = e0 + t1 * along;
  const int k =
      std::abs(along.x()) > std::abs(along.y()) ? 0 : 1;  // focal and axis by which the depth is recovered
  const double focal = k == 0 ? c.fx_px : c.fy_px, centre = k == 0 ? c.cx_px : c.cy_px;
  const auto tolerance_at_pixel = [&](double w) {
    const double n = (w - centre) / focal;
    const double denominator = slope[k] - n * slope.z();
    if (std::abs(denominator) < 1e-15) return widest;
    const double s = std::clamp((n * origin.z() - origin[k]) / denominator, s0, s1);
    return std::min(tolerance_at(s), widest);
  };
  const double tolerance = std::max(tolerance_at_pixel(p0[k]), tolerance_at_pixel(p1[k]));
  const auto [row0, row1] =
      grid.rows_between(std::min(p0.y(), p1.y()) - tolerance, std::max(p0.y(), p1.y()) + tolerance);
  // The band of the line, cut by a row of cells, in x: from the perpendicular form across . p = offset.
  for (int row = row0; row <= row1; ++row) {
    const double y_low = grid.y0 + row * grid.cell_px, y_high = y_low + grid.cell_px;
    double x_low = std::min(p0.x(), p1.x()) - tolerance, x_high = std::max(p0.x(), p1.x()) + tolerance;
    if (std::abs(across.x()) > 1e-9) {
      const double a0 = (offset - tolerance - across.y() * y_low) / across.x();
      const double a1 = (offset - tolerance - across.y() * y_high) / across.x();
      const double a2 = (offset + tolerance - across.y() * y_low) / across.x();
      const double a3 = (offset + tolerance - across.y() * y_high) / across.x();
      x_low = std::max(x_low, std::min(std::min(a0, a1), std::min(a2, a3)));
      x_high = std::min(x_high, std::max(std::max(a0, a1), std::max(a2, a3)));
    }
    const auto [column0, column1] = grid.columns_between(x_low, x_high);
    table_.visit_cells(grid, row, column0, column1, [&](std::uint32_t b) {
      if (std::abs(across.dot(table_[b].pixel) - offset) <= tolerance) candidates_.push_back(b);
    });
  }
}

}  // namespace glint
