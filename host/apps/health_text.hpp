// SPDX-License-Identifier: MIT
// What the watch over the cameras finds, in words: while a run goes on, and what it came to.
#pragma once

#include <string>
#include <vector>

#include <nlohmann/json.hpp>

#include "host/health/camera_health.hpp"
#include "host/output/report.hpp"

namespace glint::apps {

/// "camera left exposes 8.0 ms later than the others; ...". `cameras`: names in rig order.
std::string event_text(const HealthEvent& event, const std::vector<std::string>& cameras);
/// "bumped: looks 0.20 degrees to the right of where it was calibrated"
std::string state_text(const CameraState& state, const std::vector<std::string>& cameras);

/// A row for each camera.
std::vector<ReportRow> health_rows(const HealthReport& report, const std::vector<std::string>& cameras);
nlohmann::ordered_json health_json(const HealthReport& report, const std::vector<std::string>& cameras);

}  // namespace glint::apps
