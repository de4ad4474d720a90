// SPDX-License-Identifier: MIT
// Blurred elliptical discs that hide one another.
#include "host/resolve/disc_model.hpp"

#include <algorithm>

#include <Eigen/LU>

namespace glint {

void DiscModel::set_up(const ExpectedDisc& expected, const DiscProfiles& profiles) noexcept {
  // A metric in which outline and blur together have the second moments that they really have; the radius
  // is that of the disc in it. A short path of the marker is one more blur, a long one is cut into pieces.
  constexpr double kLongestPiece_px = 1.0;
  const double variance = profiles.sigma_px() * profiles.sigma_px();
  const double path_px = expected.motion_px.norm();
  nodes_ = static_cast<unsigned>(std::clamp(std::ceil(path_px / kLongestPiece_px), 1.0, double{kMaxNodes}));
  const Eigen::Vector2d piece = expected.motion_px / nodes_;
  const Eigen::Matrix2d moments =
      0.25 * expected.shape_px2 + variance * Eigen::Matrix2d::Identity() + piece * piece.transpose() / 12.0;
  const double scale = std::sqrt(std::max(moments.determinant(), variance * variance));
  metric_xx_ = static_cast<float>(moments(1, 1) / scale);
  metric_xy_ = static_cast<float>(-moments(0, 1) / scale);
  metric_yy_ = static_cast<float>(moments(0, 0) / scale);
  radius_ = 2.0 * std::sqrt(scale - variance);
  profile_ = profiles.of(radius_);
  step_x_ = static_cast<float>(piece.x());
  step_y_ = static_cast<float>(piece.y());
  reach_ = profile_.reach_px() + static_cast<float>(0.6 * path_px);
}

void DiscModel::row_range(int y, int& first, int& last) const noexcept {
  first = 0, last = -1;
  const float dy = static_cast<float>(y) - y_;
  const float square = metric_xx_ * reach_ * reach_ - dy * dy;
  if (!(square >= 0.0f)) return;
  const float half = std::sqrt(square) / metric_xx_;
  const float middle = x_ - metric_xy_ / metric_xx_ * dy;
  first = static_cast<int>(std::ceil(middle - half));
  last = static_cast<int>(std::floor(middle + half));
}

DiscModel::Seen DiscModel::at_path(float dx, float dy) const noexcept {
  Seen sum{0.0f, 0.0f, 0.0f};
  const float each = 1.0f / static_cast<float>(nodes_), first = -0.5f * static_cast<float>(nodes_ - 1);
  for (unsigned k = 0; k < nodes_; ++k) {
    const float at = first + static_cast<float>(k);
    const Seen one = at_one(dx - at * step_x_, dy - at * step_y_);
    sum.share += each * one.share;
    sum.by_x += each * one.by_x;
    sum.by_y += each * one.by_y;
  }
  return sum;
}

PixelModel::PixelModel(std::span<const ExpectedDisc> expected, const DiscProfiles& profiles,
                       const EdgeOverlap& overlap) noexcept
    : discs_(expected.size()), overlap_(overlap) {
  for (std::size_t i = 0; i < discs_; ++i) model_[i].set_up(expected[i], profiles);
}

void PixelModel::begin_row(int y, int& first, int& last) noexcept {
  model_[0].row_range(y, first_[0], last_[0]);
  first = first_[0], last = last_[0];
  for (std::size_t i = 1; i < discs_; ++i) {
    model_[i].row_range(y, first_[i], last_[i]);
    if (first_[i] > last_[i]) continue;
    first = first > last ? first_[i] : std::min(first, first_[i]);
    last = std::max(last, last_[i]);
  }
}

void PixelModel::hide(const std::array<DiscModel::Seen, kMaxDiscs>& seen, Pixel& pixel) const noexcept {
  std::array<float, kMaxDiscs> steepness;
  for (std::size_t n = 0; n < pixel.discs; ++n)
    steepness[n] = std::sqrt(seen[n].by_x * seen[n].by_x + seen[n].by_y * seen[n].by_y) + 1e-9f;
  for (std::size_t n = 1; n < pixel.discs; ++n) {
    // What the nearer discs leave of this one: share * product of (1 - both / share), each with its
    // derivatives by this disc's share and by the hiding one's.
    const DiscModel::Seen& far = seen[n];
    const float grey = grey_[pixel.disc[n]];
    const float inverse = 1.0f / far.share;
    float left = far.share, left_by_own = 1.0f;
    std::array<float, kMaxDiscs> by_other;
    for (std::size_t k = 0; k < n; ++k) {
      const DiscModel::Seen& near = seen[k];
      const float cosine = (near.by_x * far.by_x + near.by_y * far.by_y) / (steepness[k] * steepness[n]);
      const EdgeOverlap::Value both = overlap_.at(near.share, far.share, cosine);
      const float hidden = both.share * inverse;
      const float share = std::max(0.0f, 1.0f - hidden);
      for (std::size_t o = 0; o < k; ++o) by_other[o] *= share;
      by_other[k] = -left * inverse * both.by_p;
      left_by_own = left_by_own * share + left * inverse * (hidden - both.by_q);
      left *= share;
    }
    pixel.light += grey * left;
    pixel.by_grey[n] = left;
    pixel.by_x[n] = grey * left_by_own * far.by_x;
    pixel.by_y[n] = grey * left_by_own * far.by_y;
    for (std::size_t k = 0; k < n; ++k) {
      pixel.by_x[k] += grey * by_other[k] * seen[k].by_x;
      pixel.by_y[k] += grey * by_other[k] * seen[k].by_y;
    }
  }
}

}  // namespace glint
