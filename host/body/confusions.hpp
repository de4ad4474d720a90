// SPDX-License-Identifier: MIT
// Bodies that look alike, or like themselves when turned: told when they are defined, not found out in
// flight.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "host/body/body_model.hpp"
#include "host/geometry/pose.hpp"

namespace glint {

/// What a tracker with good cameras can no longer tell apart in one look.
inline constexpr double kConfusionTolerance_m = 0.003;

/// Markers of a body that lie as markers of another body (or other markers of the same one) do.
struct Agreement {
  std::vector<std::pair<std::uint32_t, std::uint32_t>> markers;  ///< of a, of b; ascending in a
  Pose a_from_b;
  double difference_m = 0.0;  ///< largest distance between two markers of a pair
};

/// All largest sets of three or more pairs that one rigid motion, never a mirror, brings together within
/// `tolerance_m`; most pairs first, then the smallest difference.
std::vector<Agreement> find_agreements(std::span<const Eigen::Vector3d> a, std::span<const Eigen::Vector3d> b,
                                       double tolerance_m);

struct Confusion {
  std::uint32_t body = 0, other = 0;  ///< the same one twice: it looks like itself when turned
  Agreement agreement;
  double turn_rad = 0.0;  ///< of the body onto itself; of two bodies it says nothing
  bool whole = false;   ///< all markers of both take part: the bodies are identical, or the body is symmetric
  bool nearly = false;  ///< all but one of the body with fewer markers: one hidden marker is enough
};

/// Every way in which one body can be taken for another or for itself turned. Bodies of three or four markers
/// have many with three pairs, which matter only while just these three are seen.
std::vector<Confusion> find_confusions(std::span<const BodyModel> models,
                                       double tolerance_m = kConfusionTolerance_m);

/// For a person: which bodies, which markers, how far they turn, by how much they differ.
std::string describe(const Confusion& confusion, std::span<const BodyModel> models);

}  // namespace glint
