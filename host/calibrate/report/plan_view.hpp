// SPDX-License-Identifier: MIT
// Two axes of the world as a picture with a grid in metres: from above or from the side.
#pragma once

#include <cstdint>
#include <span>
#include <string>

#include <Eigen/Core>

#include "host/geometry/camera.hpp"

namespace glint {

enum class PlanAxes : std::uint8_t { FromAbove, FromTheSide };  ///< x and y, or x and z

/// Maps metres to user units and draws what all such pictures have.
class PlanView {
 public:
  /// As wide as `width`; the height follows from the extent of low..high, `most_height` at most.
  PlanView(PlanAxes axes, const Eigen::Vector3d& low_in_world, const Eigen::Vector3d& high_in_world,
           double width, double most_height);

  Eigen::Vector2d operator()(const Eigen::Vector3d& point_in_world) const;
  double units_per_m() const noexcept { return units_per_m_; }
  double width() const noexcept { return width_; }
  double height() const noexcept { return height_; }
  double plot_left() const noexcept;
  double plot_right() const noexcept;
  double plot_top() const noexcept;
  double plot_bottom() const noexcept;

  std::string grid() const;  ///< lines only, to lie below all else
  std::string axes() const;  ///< labels in metres
  std::string cameras(std::span<const CameraCalibration> cameras) const;  ///< dots with names
  /// Wedges: what each camera sees, as far as `reach_m` and the plot's edges.
  std::string fields_of_view(std::span<const CameraCalibration> cameras, double reach_m) const;
  /// "x y" for a path.
  std::string at(const Eigen::Vector3d& point_in_world) const;

 private:
  Eigen::Index up_ = 1;         // axis of the world that points up in the picture
  Eigen::Vector2d low_, high_;  // of the plot, in metres, rounded outwards to the grid
  double width_ = 0, height_ = 0, units_per_m_ = 1, step_m_ = 1;
};

}  // namespace glint
