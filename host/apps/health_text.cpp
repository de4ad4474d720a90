// SPDX-License-Identifier: MIT
// Words for conditions of cameras.
#include "host/apps/health_text.hpp"

#include <cmath>
#include <cstdarg>
#include <cstdio>
#include <numbers>

namespace glint::apps {
namespace {

constexpr double kDegreesPerRadian = 180.0 / std::numbers::pi;
constexpr double kTellShare = 0.05;  // parts of a turn that are smaller are not worth a word

__attribute__((format(printf, 1, 2))) std::string text(const char* format, ...) {
  char buffer[256];
  va_list arguments;
  va_start(arguments, format);
  std::vsnprintf(buffer, sizeof buffer, format, arguments);
  va_end(arguments);
  return buffer;
}

const char* condition_key(CameraCondition condition) {
  switch (condition) {
    case CameraCondition::Fine:
      return "fine";
    case CameraCondition::Drifting:
      return "drifting";
    case CameraCondition::Bumped:
      return "bumped";
    case CameraCondition::Late:
      return "late";
    case CameraCondition::Swapped:
      return "swapped";
    case CameraCondition::Unknown:
      break;
  }
  return "unknown";
}

/// "looks 0.20 degrees to the right and 0.02 up of where it was calibrated"
std::string turn_text(const Eigen::Vector3d& turn_rad) {
  const Eigen::Vector3d degrees = turn_rad * kDegreesPerRadian;
  const auto counts = [&](double part) { return std::abs(part) >= kTellShare * degrees.norm(); };
  std::string parts;
  const auto add = [&](double part, const char* positive, const char* negative) {
    if (!counts(part)) return;
    parts += text(parts.empty() ? "looks %.2f degrees %s" : " and %.2f %s", std::abs(part),
                  part > 0.0 ? positive : negative);
  };
  add(degrees.y(), "to the right", "to the left");
  add(degrees.x(), "up", "down");
  if (!parts.empty()) parts += " of where it was calibrated";
  if (counts(degrees.z())) {
    parts += text("%sis rolled by %.2f degrees %s", parts.empty() ? "" : " and ", std::abs(degrees.z()),
                  degrees.z() > 0.0 ? "clockwise" : "anticlockwise");
  }
  return parts;
}

std::string delay_text(double late_s) {
  return text("exposes %.1f ms %s than the others", std::abs(late_s) * 1e3,
              late_s > 0.0 ? "later" : "earlier");
}

}  // namespace

std::string state_text(const CameraState& state, const std::vector<std::string>& cameras) {
  switch (state.condition) {
    case CameraCondition::Fine:
      return "fine";
    case CameraCondition::Drifting:
      return "drifting";
    case CameraCondition::Bumped:
      return "bumped: " + turn_text(state.turn_rad);
    case CameraCondition::Late:
      return delay_text(state.late_s);
    case CameraCondition::Swapped:
      return "swapped with " + cameras.at(index(state.swapped_with));
    case CameraCondition::Unknown:
      break;
  }
  return "too little seen to tell";
}

std::string event_text(const HealthEvent& event, const std::vector<std::string>& cameras) {
  const std::string& name = cameras.at(index(event.camera));
  const std::string anew = "calibrate it anew: glint calibrate extrinsics ... --only " + name;
  switch (event.state.condition) {
    case CameraCondition::Drifting:
      return "camera " + name +
             " drifts: its residuals are more than twice what its calibration promises; when there is "
             "time, " +
             anew;
    case CameraCondition::Bumped:
      return "camera " + name + " was bumped: it " + turn_text(event.state.turn_rad) + "; " + anew;
    case CameraCondition::Late:
      return "camera " + name + " " + delay_text(event.state.late_s) +
             ": check its trigger cable, its trigger mode and its delay";
    case CameraCondition::Swapped:
      return "camera " + name + " shows what " + cameras.at(index(event.state.swapped_with)) +
             " should: exchange the two cables, or the two devices in the rig file";
    case CameraCondition::Fine:
      return "camera " + name + " fits the others again";
    case CameraCondition::Unknown:
      break;
  }
  return "camera " + name + ": too little seen to tell whether it fits the others";
}

std::vector<ReportRow> health_rows(const HealthReport& report, const std::vector<std::string>& cameras) {
  std::vector<ReportRow> rows;
  if (report.cameras.size() < 3) return rows;  // nobody could tell whose fault it is
  for (std::size_t i = 0; i < report.cameras.size(); ++i) {
    const CameraReport& camera = report.cameras[i];
    std::string note;
    if (camera.compared > 0) {
      note =
          text("median residual %.3f px where %.3f px are expected, %llu of %llu points of the others agreed",
               camera.residual_px, camera.expected_px, static_cast<unsigned long long>(camera.agreed),
               static_cast<unsigned long long>(camera.compared));
    }
    rows.push_back(
        {"health of camera " + cameras.at(i), state_text(camera.state, cameras), std::move(note), false});
  }
  return rows;
}

nlohmann::ordered_json health_json(const HealthReport& report, const std::vector<std::string>& cameras) {
  nlohmann::ordered_json all = nlohmann::ordered_json::array();
  for (std::size_t i = 0; i < report.cameras.size(); ++i) {
    const CameraReport& camera = report.cameras[i];
    const CameraState& state = camera.state;
    nlohmann::ordered_json one{{"name", cameras.at(i)},
                               {"condition", condition_key(state.condition)},
                               {"compared", camera.compared},
                               {"agreed", camera.agreed},
                               {"residual_px", camera.residual_px},
                               {"expected_px", camera.expected_px},
                               {"faults", camera.faults}};
    if (state.condition == CameraCondition::Bumped) {
      one["turn_rad"] = {state.turn_rad.x(), state.turn_rad.y(), state.turn_rad.z()};
      one["offset_px"] = state.offset_px;
    }
    if (state.condition == CameraCondition::Late) one["late_s"] = state.late_s;
    if (state.condition == CameraCondition::Swapped)
      one["swapped_with"] = cameras.at(index(state.swapped_with));
    all.push_back(std::move(one));
  }
  return all;
}

}  // namespace glint::apps
