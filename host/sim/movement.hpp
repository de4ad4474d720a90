// SPDX-License-Identifier: MIT
// How all markers of a scene move, as functions of time that need no history.
#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include <Eigen/Core>

#include "host/geometry/pose.hpp"
#include "host/sim/motion.hpp"
#include "host/sim/options.hpp"

namespace glint::sim {

/// Reentrant: any thread may ask for any time.
class Movement {
 public:
  virtual ~Movement() = default;

  virtual Eigen::Vector3d position(std::uint32_t marker, double time_s) const noexcept = 0;
  MarkerState marker(std::uint32_t marker, double time_s) const noexcept {
    return {position(marker, time_s), velocity(marker, time_s)};
  }

  virtual std::uint32_t bodies() const noexcept { return 0; }
  /// Only of a body that there is.
  virtual Pose world_from_body(std::uint32_t body, double time_s) const noexcept;
  virtual std::span<const Eigen::Vector3d> body_markers(std::uint32_t body) const noexcept;

 protected:
  /// By differences; a movement that has jumps of velocity must know better.
  virtual Eigen::Vector3d velocity(std::uint32_t marker, double time_s) const noexcept;
};

/// Movement of rigid bodies with equally many markers each; marker m belongs to body m / markers of each.
class BodyMovement : public Movement {
 public:
  /// `markers_in_body`: one list per body, all of the same length.
  explicit BodyMovement(std::vector<std::vector<Eigen::Vector3d>> markers_in_body);

  Eigen::Vector3d position(std::uint32_t marker, double time_s) const noexcept override;
  std::uint32_t bodies() const noexcept override { return static_cast<std::uint32_t>(markers_.size()); }
  Pose world_from_body(std::uint32_t body, double time_s) const noexcept override = 0;
  std::span<const Eigen::Vector3d> body_markers(std::uint32_t body) const noexcept override {
    return markers_[body];
  }

 private:
  std::vector<std::vector<Eigen::Vector3d>> markers_;
};

/// What the options ask for; they must have been checked.
std::unique_ptr<const Movement> make_movement(const SimOptions& options, const Volume& volume);

}  // namespace glint::sim
