// SPDX-License-Identifier: MIT
// Calibration and rig files: structs to TOML.
#include <algorithm>
#include <filesystem>
#include <sstream>
#include <string>
#include <vector>

#include "host/base/error.hpp"
#include "host/config/bodies_file.hpp"
#include "host/config/number_text.hpp"
#include "host/config/read_calibration.hpp"
#include "host/config/rig.hpp"
#include "host/config/toml_section.hpp"
#include "host/config/write_checked.hpp"
#include "host/files/text_file.hpp"

namespace glint {
namespace {

std::string numbers_text(std::span<const double> values) {
  std::string text;
  for (const double value : values) text += (text.empty() ? "" : ", ") + exact_text(value);
  return "[" + text + "]";
}

std::string pose_text(const Pose& pose) {
  const Eigen::Vector3d& t = pose.translation;
  const Eigen::Quaterniond& q = pose.rotation;
  return "{ x_m = " + exact_text(t.x()) + ", y_m = " + exact_text(t.y()) + ", z_m = " + exact_text(t.z()) +
         ", qx = " + exact_text(q.x()) + ", qy = " + exact_text(q.y()) + ", qz = " + exact_text(q.z()) +
         ", qw = " + exact_text(q.w()) + " }";
}

std::string camera_text(const CameraCalibration& camera) {
  std::string text = "\n[[camera]]\n";
  text += "name = " + quoted_text(camera.name) + "\n";
  text += "width_px = " + std::to_string(camera.width_px) + "\n";
  text += "height_px = " + std::to_string(camera.height_px) + "\n";
  text += "fx_px = " + exact_text(camera.fx_px) + "\n";
  text += "fy_px = " + exact_text(camera.fy_px) + "\n";
  text += "cx_px = " + exact_text(camera.cx_px) + "\n";
  text += "cy_px = " + exact_text(camera.cy_px) + "\n";
  text += "k1_k2_p1_p2_k3 = " + numbers_text(camera.k1_k2_p1_p2_k3) + "\n";
  if (std::any_of(camera.intrinsics_sd.begin(), camera.intrinsics_sd.end(),
                  [](double sd) { return sd != 0.0; }))
    text += "intrinsics_sd = " + numbers_text(camera.intrinsics_sd) + "\n";
  text += "world_from_camera = " + pose_text(camera.world_from_camera) + "\n";
  text += "rms_px = " + exact_text(camera.rms_px) + "\n";
  return text;
}

std::string value_text(const ControlValue& control) {
  if (const auto* whole = std::get_if<std::int64_t>(&control.value)) return std::to_string(*whole);
  return quoted_text(std::get<std::string>(control.value));
}

std::string controls_text(const std::string& section, const std::vector<ControlValue>& controls) {
  std::string text;
  for (const ControlValue& control : controls)
    text += quoted_text(control.name) + " = " + value_text(control) + "\n";
  return text.empty() ? text : "\n[" + section + "]\n" + text;
}

std::string capture_text(const CaptureSettings& capture) {
  std::string text = "\n[capture]\n";
  text += "format = " + quoted_text(capture.format) + "\n";
  text += "rate_hz = " + exact_text(capture.rate_hz) + "  # 0.0: rig.rate_hz\n";
  text += "deadline_ms = " + exact_text(capture.deadline_ms) + "  # 0.0: half a period\n";
  text += controls_text("capture.controls", capture.controls);
  for (const CaptureCamera& camera : capture.cameras) {
    text += "\n[[capture.camera]]\n";
    text += "name = " + quoted_text(camera.name) + "\n";
    text += "device = " + quoted_text(camera.device) + "\n";
    text += controls_text("capture.camera.controls", camera.controls);
  }
  return text;
}

const char* flag_text(bool flag) { return flag ? "true" : "false"; }

std::string sync_text(const SyncSettings& sync) {
  std::string text = "\n[sync]\n";
  text += "board = " + quoted_text(sync.board) + "  # \"none\", \"auto\" or a serial number\n";
  text += std::string("follow = ") + flag_text(sync.follow) + "\n";
  text += "trigger_us = " + exact_text(sync.trigger_us) + "\n";
  text += "trigger_delay_us = " + exact_text(sync.trigger_delay_us) + "\n";
  text += "strobe_us = " + exact_text(sync.strobe_us) + "\n";
  text += "strobe_delay_us = " + exact_text(sync.strobe_delay_us) + "\n";
  text += "keepalive_ms = " + std::to_string(sync.keepalive_ms) + "  # 0: the board goes on without glint\n";
  text += std::string("sync_out = ") + flag_text(sync.sync_out) + "\n";
  text += "code_seed = " + std::to_string(sync.code_seed) + "  # 0: no coded pulses\n";
  text += "code_group = " + std::to_string(sync.code_group) + "  # 0: as recommended for the rate\n";
  for (const SyncOutput& output : sync.outputs) {
    text += "\n[[sync.output]]\n";
    text += "output = " + std::to_string(output.output) + "\n";
    text += std::string("enabled = ") + flag_text(output.enabled) + "\n";
    text += std::string("active_low = ") + flag_text(output.active_low) + "\n";
    if (output.delay_us) text += "delay_us = " + exact_text(*output.delay_us) + "\n";
    if (output.width_us) text += "width_us = " + exact_text(*output.width_us) + "\n";
    text += "every_n = " + std::to_string(output.every_n) + "\n";
    text += "phase = " + std::to_string(output.phase) + "\n";
  }
  return text;
}

/// The camera in one comment line, for a person who looks at the effective settings.
std::string camera_comment(const CameraCalibration& camera) {
  const Eigen::Vector3d& t = camera.world_from_camera.translation;
  return "#   " + quoted_text(camera.name) + "  " + std::to_string(camera.width_px) + "x" +
         std::to_string(camera.height_px) + "  fx " + short_text(camera.fx_px) + "  fy " +
         short_text(camera.fy_px) + " px  at " + short_text(t.x()) + " " + short_text(t.y()) + " " +
         short_text(t.z()) + " m\n";
}

}  // namespace

std::string to_toml(const Calibration& calibration) {
  std::string text =
      "# Calibrated cameras.\n"
      "# Pixels: (0,0) is the centre of the top-left pixel; x to the right, y down.\n"
      "# Camera frame: x right, y down, z forward. World frame: right-handed, metres.\n"
      "# world_from_camera: x_in_world = R(qx, qy, qz, qw) * x_in_camera + (x_m, y_m, z_m), so that x_m, "
      "y_m,\n"
      "# z_m is where the camera stands; the quaternion has length 1.\n"
      "# k1_k2_p1_p2_k3: radial-tangential distortion as in OpenCV. rms_px: reprojection error, 0 if "
      "unknown.\n"
      "# intrinsics_sd: standard deviations of fx fy cx cy k1 k2 p1 p2 k3, where they are known.\n";
  text += "format = 1\nkind = \"calibration\"\n";
  text += "made_at = " + quoted_text(calibration.made_at) + "\n";
  text += "made_from = " + quoted_text(calibration.made_from) + "\n";
  for (const CameraCalibration& camera : calibration.cameras) text += camera_text(camera);
  return text;
}

std::string to_toml(const Rig& rig) {
  std::string text = "format = 1\nkind = \"rig\"\n\n[rig]\n";
  text += "name = " + quoted_text(rig.name) + "\n";
  text += "rate_hz = " + exact_text(rig.rate_hz) + "\n";
  text += "marker_radius_m = " + exact_text(rig.marker_radius_m) + "  # 0.0: unknown\n";
  if (rig.calibration_path.empty()) {
    text += "# calibration = \"FILE\"  # none given\n";
  } else {
    const auto path = std::filesystem::absolute(rig.calibration_path).lexically_normal();
    text += "calibration = " + quoted_text(path.string()) + "\n";
    for (const CameraCalibration& camera : rig.calibration.cameras) text += camera_comment(camera);
  }
  text += "\n[gpu]\n";
  text += "device = " + quoted_text(rig.gpu.device) + "\n";
  text += "depth = " + std::to_string(rig.gpu.depth) + "\n";
  text += "\n[detect]\n";
  text += "threshold = " + std::to_string(rig.detect.threshold) + "\n";
  text += "background_frames = " + std::to_string(rig.detect.background_frames) + "\n";
  text += "min_area_px = " + std::to_string(rig.detect.min_area_px) + "\n";
  text += "max_area_px = " + std::to_string(rig.detect.max_area_px) + "\n";
  text += "max_blobs_per_camera = " + std::to_string(rig.detect.max_blobs_per_camera) + "\n";
  text += "\n[match]\n";
  text += "sigma_px = " + exact_text(rig.match.sigma_px) + "\n";
  text += "gate_px = " + exact_text(rig.match.gate_px) + "\n";
  text += "min_cameras = " + std::to_string(rig.match.min_cameras) + "\n";
  text += "exposure_s = " + exact_text(rig.match.exposure_s) + "\n";
  text += "most_looks = " + std::to_string(rig.match.most_looks) + "\n";
  text += "min_range_m = " + exact_text(rig.match.min_range_m) + "\n";
  text += "max_range_m = " + exact_text(rig.match.max_range_m) + "\n";
  if (rig.match.plane_height_m)
    text += "plane_height_m = " + exact_text(*rig.match.plane_height_m) + "  # of the markers; one camera\n";
  text += "\n[track]\n";
  text += "acceleration_sd_m_s2 = " + exact_text(rig.track.acceleration_sd_m_s2) + "\n";
  text += "max_speed_m_s = " + exact_text(rig.track.max_speed_m_s) + "\n";
  text += "confirm_frames_two_views = " + std::to_string(rig.track.confirm_frames_two_views) + "\n";
  text += "max_missed_frames = " + std::to_string(rig.track.max_missed_frames) + "\n";
  text += "max_predicted_sd_m = " + exact_text(rig.track.max_predicted_sd_m) + "\n";
  text += sync_text(rig.sync) + capture_text(rig.capture);
  for (const BodyModel& body : rig.bodies) text += body_section(body);
  return text;
}

bool is_rig_file(const std::filesystem::path& path) {
  if (!std::filesystem::is_regular_file(path) || std::filesystem::file_size(path) > kMaxConfigFileBytes)
    return false;
  std::istringstream lines(read_text_file(path, kMaxConfigFileBytes));
  for (std::string line; std::getline(lines, line);) {
    std::erase_if(line, [](char c) { return c == ' ' || c == '\t'; });
    if (line.starts_with("kind=\"rig\"")) return true;
  }
  return false;
}

void write_calibration(const std::filesystem::path& path, const Calibration& calibration, bool force) {
  write_checked(path, to_toml(calibration), parse_calibration,
                "a calibration must not replace; write to another file, and name that in the rig file's "
                "rig.calibration",
                force);
}

}  // namespace glint
