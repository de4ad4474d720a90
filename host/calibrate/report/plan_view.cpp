// SPDX-License-Identifier: MIT
// Grid, axes, cameras and what they see.
#include "host/calibrate/report/plan_view.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include <Eigen/Geometry>

#include "host/page/page_text.hpp"
#include "host/page/svg.hpp"

namespace glint {
namespace {

constexpr double kLeft = 50, kRight = 24, kTop = 22, kBottom = 44;
constexpr double kNameHeight = 15;

std::string name_of(const CameraCalibration& camera, std::size_t index) {
  return camera.name.empty() ? "camera " + std::to_string(index + 1) : camera.name;
}

using Polygon = std::vector<Eigen::Vector2d>;

/// What of a polygon lies on one side of a line: axis 0 or 1, `sign` * coordinate at least `least`
/// (Sutherland and Hodgman, CACM 17(1), 1974).
Polygon cut(const Polygon& polygon, int axis, double sign, double least) {
  Polygon kept;
  for (std::size_t i = 0; i < polygon.size(); ++i) {
    const Eigen::Vector2d &a = polygon[i], &b = polygon[(i + 1) % polygon.size()];
    const double in_a = sign * a[axis] - least, in_b = sign * b[axis] - least;
    if (in_a >= 0) kept.push_back(a);
    if ((in_a >= 0) != (in_b >= 0)) kept.push_back(a + in_a / (in_a - in_b) * (b - a));
  }
  return kept;
}

}  // namespace

PlanView::PlanView(PlanAxes axes, const Eigen::Vector3d& low_in_world, const Eigen::Vector3d& high_in_world,
                   double width, double most_height)
    : up_(axes == PlanAxes::FromAbove ? 1 : 2), width_(width) {
  low_ = {low_in_world.x(), low_in_world[up_]};
  high_ = {high_in_world.x(), high_in_world[up_]};
  if (!low_.allFinite() || !high_.allFinite() || !((high_ - low_).maxCoeff() > 1e-6)) {
    low_ = {0, 0};
    high_ = {1, 1};
  }
  step_m_ = round_step((high_ - low_).maxCoeff(), 7);
  for (int i = 0; i < 2; ++i) {
    // What reaches over a line by a twentieth of a step needs no further one.
    low_[i] = std::floor(low_[i] / step_m_ + 0.05) * step_m_;
    high_[i] = std::max(std::ceil(high_[i] / step_m_ - 0.05) * step_m_, low_[i] + step_m_);
  }
  const Eigen::Vector2d extent = high_ - low_;
  units_per_m_ = std::min((width - kLeft - kRight) / extent.x(), (most_height - kTop - kBottom) / extent.y());
  height_ = kTop + kBottom + extent.y() * units_per_m_;
}

double PlanView::plot_left() const noexcept {
  return kLeft + (width_ - kLeft - kRight - (high_.x() - low_.x()) * units_per_m_) / 2;
}

double PlanView::plot_bottom() const noexcept { return height_ - kBottom; }

double PlanView::plot_top() const noexcept { return plot_bottom() - (high_.y() - low_.y()) * units_per_m_; }

double PlanView::plot_right() const noexcept { return plot_left() + (high_.x() - low_.x()) * units_per_m_; }

Eigen::Vector2d PlanView::operator()(const Eigen::Vector3d& p) const {
  return {plot_left() + (p.x() - low_.x()) * units_per_m_,
          height_ - kBottom - (p[up_] - low_.y()) * units_per_m_};
}

std::string PlanView::at(const Eigen::Vector3d& point_in_world) const {
  const Eigen::Vector2d p = (*this)(point_in_world);
  return svg::coordinate(p.x()) + " " + svg::coordinate(p.y());
}

std::string PlanView::grid() const {
  std::string s;
  const double top = plot_top();
  for (double v = low_.x(); v <= high_.x() + step_m_ / 4; v += step_m_) {
    const double x = plot_left() + (v - low_.x()) * units_per_m_;
    s += svg::line("grid", x, top, x, height_ - kBottom);
  }
  for (double v = low_.y(); v <= high_.y() + step_m_ / 4; v += step_m_) {
    const double y = height_ - kBottom - (v - low_.y()) * units_per_m_;
    s += svg::line("grid", plot_left(), y, plot_right(), y);
  }
  return s;
}

std::string PlanView::axes() const {
  std::string s;
  const double bottom = plot_bottom(), top = plot_top();
  for (double v = low_.x(); v <= high_.x() + step_m_ / 4; v += step_m_) {
    const double x = plot_left() + (v - low_.x()) * units_per_m_;
    s += svg::line("tick", x, bottom, x, bottom + 4) + svg::label("mid", x, bottom + 18, short_number(v, 4));
  }
  for (double v = low_.y(); v <= high_.y() + step_m_ / 4; v += step_m_) {
    const double y = bottom - (v - low_.y()) * units_per_m_;
    s += svg::line("tick", plot_left() - 4, y, plot_left(), y);
    s += svg::label("end", plot_left() - 8, y + 4, short_number(v, 4));
  }
  s += svg::label("mid unit", (plot_left() + plot_right()) / 2, height_ - 8, "x (m)");
  return s + svg::label("mid unit", plot_left() - 8, top - 9, up_ == 1 ? "y (m)" : "z (m)");
}

std::string PlanView::cameras(std::span<const CameraCalibration> cameras) const {
  std::string s;
  std::vector<Eigen::Vector2d> taken;  // where names stand already
  for (std::size_t i = 0; i < cameras.size(); ++i) {
    const Eigen::Vector3d& eye = cameras[i].world_from_camera.translation;
    if (!eye.allFinite()) continue;
    const Eigen::Vector2d p = (*this)(eye);
    const std::string name = name_of(cameras[i], i);
    const double half = 3.6 * static_cast<double>(name.size()) + 4;
    const double x = std::clamp(p.x(), half, width_ - half);
    // Above, then ever further below: the first place that no other name has.
    double y = p.y() - 10;
    for (int k = 0; k < 32; ++k) {
      const bool free = std::none_of(taken.begin(), taken.end(), [&](const Eigen::Vector2d& other) {
        return std::abs(other.x() - x) < 2 * half && std::abs(other.y() - y) < kNameHeight;
      });
      if (free && y > 10) break;
      y = p.y() + 18 + kNameHeight * k;
    }
    taken.emplace_back(x, y);
    s += svg::circle("eye", p.x(), p.y(), 5, name) + svg::label("mid name", x, y, name);
  }
  return s;
}

std::string PlanView::fields_of_view(std::span<const CameraCalibration> cameras, double reach_m) const {
  // Many wedges on top of each other must still show what is below.
  const std::string style =
      "fill-opacity:" + short_number(std::min(0.55, 2.4 / static_cast<double>(cameras.size())), 2);
  std::string s;
  for (const CameraCalibration& calibration : cameras) {
    if (!calibration.world_from_camera.translation.allFinite()) continue;
    const Camera camera(calibration);
    const double right = calibration.width_px - 0.5, bottom = calibration.height_px - 0.5;
    const double cx = calibration.width_px / 2.0, cy = calibration.height_px / 2.0;
    // From above, the ends of the middle row; from the side, those of the middle column.
    using Two = std::array<Eigen::Vector2d, 2>;
    const Two edges = up_ == 1 ? Two{{{-0.5, cy}, {right, cy}}} : Two{{{cx, -0.5}, {cx, bottom}}};
    std::vector<Eigen::Vector3d> ends;
    for (const Eigen::Vector2d& edge : edges) {
      if (const auto plane = camera.undistort(edge))
        ends.push_back(camera.position_in_world() + reach_m * camera.direction_in_world(*plane));
    }
    if (ends.size() < 2) continue;
    Polygon wedge{(*this)(camera.position_in_world()), (*this)(ends[0]), (*this)(ends[1])};
    wedge = cut(cut(wedge, 0, 1, plot_left()), 0, -1, -plot_right());
    wedge = cut(cut(wedge, 1, 1, plot_top()), 1, -1, -plot_bottom());
    std::string corners;
    for (const Eigen::Vector2d& p : wedge)
      corners += (corners.empty() ? "M" : "L") + svg::coordinate(p.x()) + " " + svg::coordinate(p.y());
    if (!corners.empty()) s += svg::path("field", corners + "Z", style);
  }
  return s;
}

}  // namespace glint
