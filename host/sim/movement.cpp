// SPDX-License-Identifier: MIT
// What movements share, and which one the options ask for.
#include "host/sim/movement.hpp"

#include <utility>

#include "host/sim/crossing.hpp"
#include "host/sim/touching_pairs.hpp"
#include "host/sim/tumbling.hpp"
#include "host/sim/wand_dance.hpp"

namespace glint::sim {
namespace {

/// Balls on flights of their own.
class Thrown final : public Movement {
 public:
  Thrown(const SimOptions& options, const Volume& volume) : flights_(throw_markers(options, volume)) {}

  Eigen::Vector3d position(std::uint32_t marker, double time_s) const noexcept override {
    return flights_[marker].at(time_s).position_in_world;
  }

 private:
  Eigen::Vector3d velocity(std::uint32_t marker, double time_s) const noexcept override {
    return flights_[marker].at(time_s).velocity_in_world;
  }

  std::vector<Flight> flights_;
};

}  // namespace

Pose Movement::world_from_body(std::uint32_t, double) const noexcept { return {}; }

std::span<const Eigen::Vector3d> Movement::body_markers(std::uint32_t) const noexcept { return {}; }

Eigen::Vector3d Movement::velocity(std::uint32_t marker, double time_s) const noexcept {
  constexpr double kStep_s = 1e-4;  // of motions that change within tenths of seconds
  return (position(marker, time_s + kStep_s) - position(marker, time_s - kStep_s)) / (2.0 * kStep_s);
}

BodyMovement::BodyMovement(std::vector<std::vector<Eigen::Vector3d>> markers_in_body)
    : markers_(std::move(markers_in_body)) {}

Eigen::Vector3d BodyMovement::position(std::uint32_t marker, double time_s) const noexcept {
  const std::size_t each = markers_.front().size(), body = marker / each;
  return world_from_body(static_cast<std::uint32_t>(body), time_s) * markers_[body][marker % each];
}

std::unique_ptr<const Movement> make_movement(const SimOptions& options, const Volume& volume) {
  switch (options.motion) {
    case SimMotion::Wand:
      return std::make_unique<WandDance>(options, volume);
    case SimMotion::Tumbling:
      return std::make_unique<Tumbling>(options, volume);
    case SimMotion::Crossing:
      return std::make_unique<Crossing>(options, volume);
    case SimMotion::Pairs:
      return std::make_unique<TouchingPairs>(options, volume);
    case SimMotion::Thrown:
      break;
  }
  return std::make_unique<Thrown>(options, volume);
}

}  // namespace glint::sim
