// SPDX-License-Identifier: MIT
// Where markers lie that do not move.
#pragma once

#include <vector>

#include <Eigen/Core>

#include "host/apps/run_arguments.hpp"

namespace glint::apps {

/// Tracks the source to its end and gives the mean places of the markers that were seen in most of it, all of
/// which must have lain still to a millimetre. Throws Error, UsageError.
std::vector<Eigen::Vector3d> still_markers(const RunArguments& arguments, bool quiet);

}  // namespace glint::apps
