// SPDX-License-Identifier: MIT
// What `glint calibrate intrinsics` has found, for people and for programs.
#pragma once

#include <span>
#include <string>

#include <nlohmann/json.hpp>

#include "host/calibrate/intrinsics.hpp"

namespace glint::apps {

/// Some lines, with line ends.
std::string intrinsics_text(const IntrinsicsResult& result);
/// One line for each parameter: by how much it differs from the truth, in pixels or of its own, and in
/// standard deviations.
std::string truth_text(const IntrinsicsResult& result, const CameraCalibration& truth);

nlohmann::ordered_json intrinsics_json(const std::string& board, std::span<const IntrinsicsResult> results);

}  // namespace glint::apps
