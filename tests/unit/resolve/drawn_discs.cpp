// SPDX-License-Identifier: MIT
// What each disc shows, cut out exactly and drawn by the simulator's blur.
#include "tests/unit/resolve/drawn_discs.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include <Eigen/Cholesky>
#include <Eigen/LU>

#include "host/sim/backdrop.hpp"
#include "host/sim/blur.hpp"

namespace glint::testing {
namespace {

using sim::OutlinePoint;

constexpr int kPoints = 1440;

bool inside(const TrueDisc& disc, const Eigen::Vector2d& at_px) {
  const Eigen::Vector2d v = at_px - disc.centre_px;
  return v.dot(disc.shape_px2.inverse() * v) < 1.0;
}

bool cut_away(const TrueDisc& disc, const Eigen::Vector2d& at_px) {
  return (at_px - disc.centre_px).dot(disc.edge_normal) > disc.edge_px;
}

/// Outline points with their steps, from +x to +y.
std::vector<OutlinePoint> ring(const TrueDisc& disc) {
  const Eigen::Matrix2d root = disc.shape_px2.llt().matrixL();
  std::vector<OutlinePoint> points(kPoints);
  const double step = 2.0 * std::numbers::pi / kPoints;
  for (int i = 0; i < kPoints; ++i) {
    const double c = std::cos(step * i), s = std::sin(step * i);
    const Eigen::Vector2d at = disc.centre_px + root * Eigen::Vector2d(c, s);
    const Eigen::Vector2d along = root * Eigen::Vector2d(-s, c) * step;
    points[static_cast<std::size_t>(i)] = {at.x(), at.y(), along.x(), along.y()};
  }
  return points;
}

/// The outline of what is left of `disc` behind the others: its own arcs that show, the arcs of the nearer
/// discs and the edge that cut into it, run backwards. (No three discs may meet in one another.)
std::vector<OutlinePoint> shown_outline(const TrueDisc& disc, std::span<const TrueDisc> discs) {
  std::vector<OutlinePoint> outline;
  const auto covered = [&](const Eigen::Vector2d& at, const TrueDisc* but) {
    return std::any_of(discs.begin(), discs.end(), [&](const TrueDisc& other) {
      return &other != but && other.distance_m < disc.distance_m && inside(other, at) && !cut_away(other, at);
    });
  };
  for (const OutlinePoint& p : ring(disc)) {
    const Eigen::Vector2d at(p.x_px, p.y_px);
    if (!covered(at, nullptr) && !cut_away(disc, at)) outline.push_back(p);
  }
  for (const TrueDisc& other : discs) {
    if (!(other.distance_m < disc.distance_m)) continue;
    for (OutlinePoint p : ring(other)) {
      const Eigen::Vector2d at(p.x_px, p.y_px);
      if (!inside(disc, at) || covered(at, &other) || cut_away(disc, at)) continue;
      p.dx_px = -p.dx_px, p.dy_px = -p.dy_px;
      outline.push_back(p);
    }
  }
  // The chord, which runs 90 degrees from the normal.
  const Eigen::Vector2d along(-disc.edge_normal.y(), disc.edge_normal.x());
  const double half = std::sqrt(disc.shape_px2.trace());
  const Eigen::Vector2d step = 2.0 * half / kPoints * along;
  for (int i = 0; i < kPoints && disc.edge_px < half; ++i) {
    const Eigen::Vector2d at =
        disc.centre_px + disc.edge_px * disc.edge_normal - half * along + (i + 0.5) * step;
    if (inside(disc, at) && !covered(at, nullptr)) outline.push_back({at.x(), at.y(), step.x(), step.y()});
  }
  return outline;
}

}  // namespace

TrueDisc round_disc(const Eigen::Vector2d& centre_px, double radius_px, double grey, double distance_m) {
  TrueDisc disc;
  disc.centre_px = centre_px;
  disc.shape_px2 = radius_px * radius_px * Eigen::Matrix2d::Identity();
  disc.grey = grey;
  disc.distance_m = distance_m;
  return disc;
}

double edge_that_hides(double share) {
  double low = -1.0, high = 1.0;
  for (int i = 0; i < 50; ++i) {
    const double t = 0.5 * (low + high);
    const double hidden = (std::acos(t) - t * std::sqrt(1.0 - t * t)) / std::numbers::pi;
    (hidden > share ? low : high) = t;
  }
  return low;
}

DrawnImage draw(std::uint32_t width_px, std::uint32_t height_px, double dark_grey,
                std::span<const TrueDisc> discs, const PixelNoise& noise, sim::Random& random,
                const sim::NormalTable& normal) {
  const sim::BlurKernel kernel(noise.psf_sigma_px);
  sim::Patch patch;
  patch.reset(0, 0, static_cast<int>(width_px) - 1, static_cast<int>(height_px) - 1, false);
  for (const TrueDisc& disc : discs) patch.add_filled(kernel, shown_outline(disc, discs), 1.0, disc.grey);
  DrawnImage image{width_px, height_px, {}, {}};
  for (int y = 0; y < patch.height_px(); ++y) {
    for (int x = 0; x < patch.width_px(); ++x) {
      const auto light = static_cast<double>(patch.row(y)[x]);
      image.mean.push_back(dark_grey + light);
      const double sd = std::sqrt(noise.variance_grey2(light) - 1.0 / 12.0);  // rounding comes by itself
      image.pixels.push_back(sim::to_pixel(
          static_cast<float>(dark_grey + light + sd * static_cast<double>(normal.draw(random)))));
    }
  }
  return image;
}

Eigen::MatrixXd smallest_covariance_px2(std::uint32_t width_px, std::uint32_t height_px, double dark_grey,
                                        std::span<const TrueDisc> discs, const PixelNoise& noise) {
  constexpr double kStep = 1e-2;
  sim::Random random(1);
  const sim::NormalTable normal;
  const auto mean = [&](std::span<const TrueDisc> of) {
    const DrawnImage image = draw(width_px, height_px, dark_grey, of, noise, random, normal);
    return Eigen::VectorXd(
        Eigen::Map<const Eigen::VectorXd>(image.mean.data(), static_cast<Eigen::Index>(image.mean.size())));
  };
  const Eigen::VectorXd at = mean(discs);
  const auto n = static_cast<Eigen::Index>(discs.size());
  Eigen::MatrixXd by(at.size(), 3 * n + 1);
  for (Eigen::Index i = 0; i < n; ++i) {
    for (Eigen::Index k = 0; k < 3; ++k) {
      std::vector<TrueDisc> up(discs.begin(), discs.end()), down = up;
      TrueDisc &a = up[static_cast<std::size_t>(i)], &b = down[static_cast<std::size_t>(i)];
      if (k < 2) {
        a.centre_px[k] += kStep, b.centre_px[k] -= kStep;
        // What hides the disc stays where it is.
        a.edge_px -= kStep * a.edge_normal[k], b.edge_px += kStep * b.edge_normal[k];
      } else {
        a.grey += kStep, b.grey -= kStep;
      }
      by.col(k < 2 ? 2 * i + k : 2 * n + i) = (mean(up) - mean(down)) / (2.0 * kStep);
    }
  }
  by.col(3 * n).setOnes();
  Eigen::VectorXd weight(at.size());
  for (Eigen::Index i = 0; i < at.size(); ++i)
    weight[i] = at[i] < 254.5 ? 1.0 / noise.variance_grey2(at[i] - dark_grey) : 0.0;
  const Eigen::MatrixXd information = by.transpose() * weight.asDiagonal() * by;
  return information.inverse().topLeftCorner(2 * n, 2 * n);
}

}  // namespace glint::testing
