// SPDX-License-Identifier: MIT
// Blobs whose size does not fit the marker that they are taken for.
#pragma once

#include <array>
#include <cstdint>
#include <span>

#include <Eigen/Core>

#include "host/geometry/triangulate.hpp"
#include "host/match/blob_table.hpp"
#include "host/match/blob_tuple.hpp"

namespace glint {

/// A blob much larger than the marker has another one merged into it, a much smaller one is partly hidden:
/// either way its centroid is off by about the difference of the radii, which is added to its view's
/// covariance. What is right is the known radius, or what most of at least three views say. Returns the
/// cameras whose views were widened, as bits.
std::uint32_t widen_odd_sizes(std::span<const Camera> cameras, const MatchOptions& options,
                              const BlobTable& table, const BlobTuple& tuple,
                              const Eigen::Vector3d& position_in_world,
                              std::array<Observation, kMatchCameras>& views) noexcept;

}  // namespace glint
