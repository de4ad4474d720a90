// SPDX-License-Identifier: MIT
// Live cameras in a rig file: TOML to structs.
#include "host/config/read_capture.hpp"

#include <algorithm>
#include <tuple>
#include <utility>

#include "host/config/number_text.hpp"

namespace glint {
namespace {

constexpr double kMaxRateHz = 10'000.0, kMaxDeadline_ms = 1'000.0;

/// In the order of the file: one control may decide whether another can be set.
void read_controls(TomlSection& parent, const std::string& full_name, std::vector<ControlValue>& controls,
                   FileProblems& problems) {
  const toml::table* table = parent.table("controls", Need::Optional);
  if (!table) return;
  std::vector<std::pair<toml::source_position, ControlValue>> found;
  for (const auto& [key, value] : *table) {
    ControlValue control{std::string(key.str()), {}};
    if (const auto* whole = value.as_integer()) {
      control.value = whole->get();
    } else if (const auto* yes = value.as_boolean()) {
      control.value = std::int64_t{yes->get()};
    } else if (const auto* text = value.as_string()) {
      control.value = text->get();
    } else {
      problems.add(value.source().begin,
                   full_name + ".controls." + control.name +
                       " must be a whole number, true or false, or a menu's item in quotes");
      continue;
    }
    found.emplace_back(key.source().begin, std::move(control));
  }
  std::stable_sort(found.begin(), found.end(), [](const auto& a, const auto& b) {
    return std::tie(a.first.line, a.first.column) < std::tie(b.first.line, b.first.column);
  });
  for (auto& [at, control] : found) controls.push_back(std::move(control));
}

std::string names_of(const Calibration& calibration) {
  std::string text;
  for (const CameraCalibration& camera : calibration.cameras)
    text += (text.empty() ? "" : ", ") + camera.name;
  return text;
}

void read_camera(const toml::table& table, const Calibration& calibration, CaptureSettings& capture,
                 FileProblems& problems) {
  const std::string number = std::to_string(capture.cameras.size() + 1);
  TomlSection section(table, "capture.camera " + number, problems);
  CaptureCamera camera;
  const auto taken = [&](const std::string CaptureCamera::*field) {
    return std::any_of(capture.cameras.begin(), capture.cameras.end(),
                       [&](const CaptureCamera& other) { return other.*field == camera.*field; });
  };
  if (section.text("name", camera.name, Need::Required)) {
    const auto& known = calibration.cameras;
    if (!known.empty() && std::none_of(known.begin(), known.end(), [&](const CameraCalibration& other) {
          return other.name == camera.name;
        })) {
      section.problem("name", "\"" + camera.name +
                                  "\" is no camera of the calibration, which has: " + names_of(calibration));
    } else if (taken(&CaptureCamera::name)) {
      section.problem("name", "\"" + camera.name + "\" stands here twice");
    }
  }
  if (section.text("device", camera.device, Need::Required)) {
    if (camera.device.empty()) {
      section.problem("device", "must not be empty (glint devices lists what there is)");
    } else if (taken(&CaptureCamera::device)) {
      section.problem("device", "\"" + camera.device + "\" is another camera's already");
    }
  }
  read_controls(section, "capture.camera " + number, camera.controls, problems);
  section.finish();
  capture.cameras.push_back(std::move(camera));
}

}  // namespace

void CaptureSettings::check(std::vector<std::string>& problems) const {
  const auto require = [&](bool fine, const std::string& text) {
    if (!fine) problems.push_back("capture." + text);
  };
  require(format == "auto" || format == "grey" || format == "nv12" || format == "yuyv" || format == "mjpeg",
          "format must be \"auto\", \"grey\", \"nv12\", \"yuyv\" or \"mjpeg\", not \"" + format + "\"");
  require(
      rate_hz >= 0.0 && rate_hz <= kMaxRateHz,
      "rate_hz must be 0 (that of the rig) to " + short_text(kMaxRateHz) + ", not " + short_text(rate_hz));
  require(deadline_ms >= 0.0 && deadline_ms <= kMaxDeadline_ms, "deadline_ms must be 0 (half a period) to " +
                                                                    short_text(kMaxDeadline_ms) + ", not " +
                                                                    short_text(deadline_ms));
}

void read_capture(TomlSection& section, const Calibration& calibration, CaptureSettings& capture,
                  FileProblems& problems) {
  section.text("format", capture.format, Need::Optional);
  section.number("rate_hz", capture.rate_hz, Need::Optional);
  section.number("deadline_ms", capture.deadline_ms, Need::Optional);
  read_controls(section, "capture", capture.controls, problems);
  const toml::array* cameras = section.tables("camera", Need::Optional);
  if (!cameras) return;
  for (const toml::node& node : *cameras) read_camera(*node.as_table(), calibration, capture, problems);
}

}  // namespace glint
