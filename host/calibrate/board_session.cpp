// SPDX-License-Identifier: MIT
// Novelty, tilt and size of the views of a board.
#include "host/calibrate/board_session.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <numbers>

#include <Eigen/Geometry>
#include <Eigen/LU>

#include "host/base/check.hpp"
#include "host/calibrate/homography.hpp"
#include "host/calibrate/zhang_start.hpp"

namespace glint {
namespace {

constexpr double kMoved = 0.03;  // of the image's width

double degrees(double angle_rad) { return angle_rad * 180.0 / std::numbers::pi; }

std::string filled(const char* text, auto... values) {
  char line[200];
  std::snprintf(line, sizeof line, text, values...);
  return line;
}

double least_distance(std::span<const Eigen::Vector2d> points) {
  double least = 1e9;
  for (std::size_t i = 1; i < points.size(); ++i) least = std::min(least, (points[i] - points[0]).norm());
  return least;
}

/// How far that corner is from itself, of those in both views, that moved most; infinity if they share fewer
/// than four.
double moved_px(const BoardPoints& a, const BoardPoints& b) {
  double most = 0.0;
  std::size_t shared = 0, j = 0;
  for (std::size_t i = 0; i < a.points.size(); ++i) {
    while (j < b.points.size() && b.points[j] < a.points[i]) ++j;
    if (j == b.points.size()) break;
    if (b.points[j] != a.points[i]) continue;
    most = std::max(most, (a.pixels[i] - b.pixels[j]).norm());
    ++shared;
  }
  return shared < 4 ? 1e9 : most;
}

}  // namespace

std::string parallel_sentence(double largest_turn_rad) {
  return filled(
      "all views of the board are within %.0f degrees of one another, and parallel views do not tell the "
      "focal "
      "length from the distance; tilt the board by 20 to 45 degrees, to all sides",
      degrees(largest_turn_rad));
}

BoardSession::BoardSession(const Target& board, std::uint32_t width_px, std::uint32_t height_px,
                           BoardWants wants)
    : width_px_(width_px), height_px_(height_px), wants_(wants), coverage_(width_px, height_px) {
  for (const Eigen::Vector3d& p : board.points_in_target) plane_.push_back(p.head<2>());
  GLINT_CHECK(plane_.size() >= 4);
  square_m_ = least_distance(plane_);
}

bool BoardSession::is_new(const BoardPoints& view) const {
  const double least_px = kMoved * width_px_;
  return std::none_of(views_.begin(), views_.end(),
                      [&](const BoardPoints& known) { return moved_px(view, known) < least_px; });
}

bool BoardSession::add(const BoardPoints& view) {
  if (!is_new(view)) return false;
  add_always(view);
  return true;
}

void BoardSession::add_always(const BoardPoints& view) {
  std::vector<Eigen::Vector2d> plane;
  for (const std::uint32_t point : view.points) plane.push_back(plane_[point]);
  const auto h = find_homography(plane, view.pixels);
  if (!h) return;  // corners of one line
  views_.push_back(view);
  homographies_.push_back(*h);
  Eigen::AlignedBox2d box;
  for (const Eigen::Vector2d& pixel : view.pixels) {
    coverage_.add(pixel);
    box.extend(pixel);
  }
  largest_share_ = std::max({largest_share_, box.sizes().x() / width_px_, box.sizes().y() / height_px_});
  // The area of a square at the middle of the view, by the homography's derivative.
  const Eigen::Vector2d middle = plane[plane.size() / 2];
  const Eigen::Vector3d at = *h * middle.homogeneous();
  const Eigen::Matrix2d slope =
      (h->topLeftCorner<2, 2>() - (at.head<2>() / at.z()) * h->row(2).head<2>()) / at.z();
  square_px_.push_back(square_m_ * std::sqrt(std::abs(slope.determinant())));
}

BoardSession::Tilts BoardSession::tilts() const {
  const CameraCalibration guess = zhang_start(homographies_, width_px_, height_px_);
  Tilts tilts;
  std::vector<Eigen::Vector3d> normals;
  double left = 1e9, right = -1e9, up = 1e9, down = -1e9;
  for (const Eigen::Matrix3d& h : homographies_) {
    const Eigen::Vector3d normal = plane_normal(guess, h);
    for (const Eigen::Vector3d& other : normals)
      tilts.largest_turn_rad =
          std::max(tilts.largest_turn_rad, std::acos(std::clamp(normal.dot(other), -1.0, 1.0)));
    normals.push_back(normal);
    const double across = std::atan2(normal.x(), -normal.z()), along = std::atan2(normal.y(), -normal.z());
    left = std::min(left, across);
    right = std::max(right, across);
    up = std::min(up, along);
    down = std::max(down, along);
  }
  if (!normals.empty()) {
    tilts.left_right_rad = right - left;
    tilts.up_down_rad = down - up;
  }
  return tilts;
}

double BoardSession::square_px() const {
  if (square_px_.empty()) return 0.0;
  std::vector<double> sides = square_px_;
  const auto middle = sides.begin() + static_cast<std::ptrdiff_t>(sides.size() / 2);
  std::nth_element(sides.begin(), middle, sides.end());
  return *middle;
}

std::vector<std::string> BoardSession::blocking() const {
  std::vector<std::string> reasons;
  if (views_.size() < wants_.least_views) {
    reasons.push_back(filled("only %zu different views of the board; show it in %zu at least, %zu are good",
                             views_.size(), wants_.least_views, wants_.views));
    return reasons;
  }
  if (const double turn = tilts().largest_turn_rad; turn < wants_.least_tilt_rad)
    reasons.push_back(parallel_sentence(turn));
  if (const double side = square_px(); side < wants_.least_square_px) {
    reasons.push_back(filled(
        "the board is too small in the image: its squares measure %.1f pixels, %.0f are the least; bring it "
        "nearer, or print larger squares",
        side, wants_.least_square_px));
  }
  return reasons;
}

std::vector<std::string> BoardSession::missing() const {
  std::vector<std::string> sentences = blocking();
  if (views_.size() < wants_.least_views) return sentences;
  const Tilts now = tilts();
  if (now.left_right_rad < wants_.tilt_rad) {
    sentences.push_back(
        filled("turn the board's left and right side towards the camera: %.0f degrees so far, %.0f "
               "are good",
               degrees(now.left_right_rad), degrees(wants_.tilt_rad)));
  }
  if (now.up_down_rad < wants_.tilt_rad) {
    sentences.push_back(
        filled("tip the board's upper and lower edge towards the camera: %.0f degrees so far, %.0f "
               "are good",
               degrees(now.up_down_rad), degrees(wants_.tilt_rad)));
  }
  if (coverage_.share(wants_.per_cell) < wants_.covered) {
    const std::string where = coverage_.sentence(wants_.per_cell);
    sentences.push_back(where.empty() ? "show the board all over the image, up to its edges" : where);
  }
  if (largest_share_ < wants_.board_across) {
    sentences.push_back(
        filled("bring the board nearer: it never fills more than %.0f %% of the image's width",
               100.0 * largest_share_));
  }
  if (views_.size() < wants_.views)
    sentences.push_back(filled("%zu views so far; %zu are good", views_.size(), wants_.views));
  return sentences;
}

}  // namespace glint
