// SPDX-License-Identifier: MIT
// What a pixel shows of a few discs, with derivatives.
#pragma once

#include <array>
#include <cmath>
#include <cstddef>
#include <span>

#include "host/resolve/disc_fit.hpp"

namespace glint {

/// One disc as the fit sees it: a profile over a metric, so that an ellipse costs no more than a circle.
class DiscModel {
 public:
  /// What one pixel sees of this disc alone.
  struct Seen {
    float share;       ///< of the disc's brightness
    float by_x, by_y;  ///< derivatives by the centre; they point outwards
  };

  void set_up(const ExpectedDisc& expected, const DiscProfiles& profiles) noexcept;
  void move_to(const Eigen::Vector2d& centre_px) noexcept {
    x_ = static_cast<float>(centre_px.x()), y_ = static_cast<float>(centre_px.y());
  }
  /// Pixels of a row that may see the disc; first > last where none does.
  void row_range(int y, int& first, int& last) const noexcept;
  Seen at(int x, int y) const noexcept {
    const float dx = static_cast<float>(x) - x_, dy = static_cast<float>(y) - y_;
    return nodes_ == 1 ? at_one(dx, dy) : at_path(dx, dy);
  }

  double radius_px() const noexcept { return radius_; }

 private:
  static constexpr unsigned kMaxNodes = 8;  // along the path of a fast marker

  Seen at_one(float dx, float dy) const noexcept {
    const float gx = metric_xx_ * dx + metric_xy_ * dy, gy = metric_xy_ * dx + metric_yy_ * dy;
    const DiscProfile::Value value = profile_.at(std::sqrt(gx * dx + gy * dy));
    return {value.share, -value.slope_over_r * gx, -value.slope_over_r * gy};
  }
  Seen at_path(float dx, float dy) const noexcept;

  float x_ = 0.0f, y_ = 0.0f;
  float metric_xx_ = 1.0f, metric_xy_ = 0.0f, metric_yy_ = 1.0f;  // determinant 1
  float reach_ = 0.0f;
  float step_x_ = 0.0f, step_y_ = 0.0f;  // from node to node
  unsigned nodes_ = 1;
  double radius_ = 0.0;
  DiscProfile profile_;
};

/// All discs together, in the order of their distances: an earlier one hides a later one.
class PixelModel {
 public:
  /// What one pixel shows; the first `discs` entries of each array are valid.
  struct Pixel {
    std::size_t discs;                                 ///< that it sees
    std::array<std::size_t, kMaxDiscs> disc;           ///< which, ascending
    std::array<float, kMaxDiscs> by_x, by_y, by_grey;  ///< derivatives by their parameters
    float light;                                       ///< above the background
  };

  /// `expected` in that order.
  PixelModel(std::span<const ExpectedDisc> expected, const DiscProfiles& profiles,
             const EdgeOverlap& overlap) noexcept;

  std::size_t discs() const noexcept { return discs_; }
  void set(std::size_t disc, const Eigen::Vector2d& centre_px, double grey) noexcept {
    model_[disc].move_to(centre_px);
    grey_[disc] = static_cast<float>(grey);
  }
  double radius_px(std::size_t disc) const noexcept { return model_[disc].radius_px(); }

  /// Must come before at() of that row. Pixels outside first..last see no disc.
  void begin_row(int y, int& first, int& last) noexcept;
  /// The same as at() of a model with one disc, for less: only entry 0 of the arrays is set.
  bool at_only_disc(int x, int y, Pixel& pixel) const noexcept {
    const DiscModel::Seen seen = model_[0].at(x, y);
    if (seen.share < kComplete) return false;
    const float grey = grey_[0];
    pixel.by_x[0] = grey * seen.by_x;
    pixel.by_y[0] = grey * seen.by_y;
    pixel.by_grey[0] = seen.share;
    pixel.light = grey * seen.share;
    return true;
  }
  /// Whether it sees any disc; `pixel` is set only then.
  bool at(int x, int y, Pixel& pixel) const noexcept {
    std::array<DiscModel::Seen, kMaxDiscs> seen;
    std::size_t n = 0;
    for (std::size_t i = 0; i < discs_; ++i) {
      if (x < first_[i] || x > last_[i]) continue;
      seen[n] = model_[i].at(x, y);
      if (seen[n].share < kComplete) continue;
      pixel.disc[n++] = i;
      if (seen[n - 1].share > 1.0f - kComplete) break;  // the rest is behind it
    }
    pixel.discs = n;
    if (n == 0) return false;
    const float grey = grey_[pixel.disc[0]];
    pixel.by_x[0] = grey * seen[0].by_x;
    pixel.by_y[0] = grey * seen[0].by_y;
    pixel.by_grey[0] = seen[0].share;
    pixel.light = grey * seen[0].share;
    if (n > 1) hide(seen, pixel);
    return true;
  }

 private:
  // Shares below this, or above 1 minus this, count as none or all.
  static constexpr float kComplete = 1e-3f;
  void hide(const std::array<DiscModel::Seen, kMaxDiscs>& seen, Pixel& pixel) const noexcept;

  std::size_t discs_;
  const EdgeOverlap& overlap_;
  std::array<DiscModel, kMaxDiscs> model_;
  std::array<float, kMaxDiscs> grey_{};
  std::array<int, kMaxDiscs> first_{}, last_{};
};

}  // namespace glint
