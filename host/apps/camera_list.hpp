// SPDX-License-Identifier: MIT
// The cameras of this computer, as people and programs see them.
#pragma once

#include <nlohmann/json_fwd.hpp>

namespace glint::apps {

/// To standard output.
void print_camera_list();
/// {"cameras": [...], "cameras_problem": "..."} into `json`.
void add_camera_list(nlohmann::ordered_json& json);

}  // namespace glint::apps
