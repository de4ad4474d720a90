// SPDX-License-Identifier: MIT
// Tables of glint with the bodies known: the same figures of markers, and those of poses.
#pragma once

#include <span>
#include <string>

#include <nlohmann/json.hpp>

#include "benchmarks/identity/run_scene.hpp"

namespace glint::identity {

/// Median and worst over the seeds, one row for each scene with bodies. "" without such a scene.
std::string poses_table(std::span<const SceneRun> runs);
nlohmann::ordered_json poses_json(const PoseResult& poses);

}  // namespace glint::identity
