// SPDX-License-Identifier: MIT
// Which device is which camera, and what is asked of it.
#include "host/apps/live_cameras.hpp"

#include <unistd.h>

#include <algorithm>
#include <charconv>
#include <cstdio>

#include "host/assemble/code_alignment.hpp"
#include "host/base/error.hpp"
#include "host/capture/camera_names.hpp"

namespace glint::apps {
namespace {

struct NamedDevice {
  std::string name, device;
};

std::vector<NamedDevice> split(std::string_view devices) {
  std::vector<NamedDevice> all;
  while (true) {
    const auto comma = devices.find(',');
    const std::string_view word = devices.substr(0, comma);
    const auto equals = word.find('=');
    NamedDevice one;
    if (equals != std::string_view::npos) one.name = word.substr(0, equals);
    one.device = word.substr(equals == std::string_view::npos ? 0 : equals + 1);
    if (one.device.empty() || (equals == 0))
      throw UsageError("v4l2: \"" + std::string(word) +
                       "\" must be DEVICE or NAME=DEVICE (glint devices lists them)");
    all.push_back(std::move(one));
    if (comma == std::string_view::npos) return all;
    devices.remove_prefix(comma + 1);
  }
}

/// Devices of the command line, one for each camera of the calibration and in its order.
std::vector<NamedDevice> devices_of_words(std::string_view words, const std::vector<std::string>& wanted) {
  std::vector<NamedDevice> given = split(words);
  const bool no_names =
      std::all_of(given.begin(), given.end(), [](const NamedDevice& one) { return one.name.empty(); });
  if (no_names && !wanted.empty() && given.size() != wanted.size()) {
    throw UsageError("v4l2: " + std::to_string(given.size()) + " devices for the " +
                     std::to_string(wanted.size()) + " cameras of the calibration: " + join_names(wanted));
  }
  std::vector<std::string> found;
  for (std::size_t n = 0; n < given.size(); ++n) {
    if (given[n].name.empty())
      given[n].name = no_names && !wanted.empty() ? wanted[n] : "cam" + std::to_string(n + 1);
    found.push_back(given[n].name);
  }
  std::vector<NamedDevice> ordered;
  for (const std::size_t n : select_cameras(found, wanted, "v4l2")) ordered.push_back(given[n]);
  return ordered;
}

/// Devices of the rig file, likewise.
std::vector<NamedDevice> devices_of_rig(const Rig& rig) {
  std::vector<NamedDevice> all;
  std::string missing;
  for (const CameraCalibration& camera : rig.calibration.cameras) {
    const auto found = std::find_if(rig.capture.cameras.begin(), rig.capture.cameras.end(),
                                    [&](const CaptureCamera& one) { return one.name == camera.name; });
    if (found == rig.capture.cameras.end()) {
      missing += (missing.empty() ? "" : ", ") + camera.name;
    } else {
      all.push_back({camera.name, found->device});
    }
  }
  if (rig.calibration.cameras.empty())
    throw UsageError("v4l2: needs devices (v4l2:DEVICE,DEVICE,...) or a rig file that names them (--rig)");
  if (!missing.empty()) {
    throw UsageError(rig.path.string() + ": no [[capture.camera]] tells the device of " + missing +
                     "; add it, or name all devices: v4l2:NAME=DEVICE,...");
  }
  return all;
}

FrameSize size_of(const std::string& text) {
  FrameSize size;
  const char* const end = text.data() + text.size();
  const auto width = std::from_chars(text.data(), end, size.width_px);
  if (width.ec == std::errc{} && width.ptr != end && *width.ptr == 'x') {
    const auto height = std::from_chars(width.ptr + 1, end, size.height_px);
    if (height.ec == std::errc{} && height.ptr == end && size.width_px > 0 && size.height_px > 0) return size;
  }
  throw UsageError("--camera-size " + text + ": must be WIDTHxHEIGHT, like 1280x800");
}

std::vector<ControlSetting> controls_of(const Rig& rig, const std::string& camera) {
  std::vector<ControlSetting> settings;
  for (const ControlValue& control : rig.capture.controls) settings.push_back({control.name, control.value});
  for (const CaptureCamera& one : rig.capture.cameras) {
    if (one.name != camera) continue;
    for (const ControlValue& control : one.controls) {
      const auto same = std::find_if(settings.begin(), settings.end(), [&](const ControlSetting& setting) {
        return control_word(setting.name) == control_word(control.name);
      });
      if (same != settings.end()) settings.erase(same);
      settings.push_back({control.name, control.value});
    }
  }
  return settings;
}

}  // namespace

void print_event(const std::string& text) {
  // The status line may stand there unfinished.
  const char* const clear = isatty(STDERR_FILENO) == 1 ? "\r\033[K" : "";
  std::fprintf(stderr, "%sglint: %s\n", clear, text.c_str());
}

V4l2Options live_options(std::string_view devices, double pulse_rate_hz, const Rig& rig,
                         const LiveArguments& arguments) {
  const auto& calibrated = rig.calibration.cameras;
  std::vector<std::string> wanted;
  for (const CameraCalibration& camera : calibrated) wanted.push_back(camera.name);
  const std::vector<NamedDevice> named =
      devices.empty() ? devices_of_rig(rig) : devices_of_words(devices, wanted);

  const std::string& format = arguments.format.empty() ? rig.capture.format : arguments.format;
  const auto kind = pixel_kind_named(format);
  if (!kind && format != "auto")
    throw UsageError("--camera-format " + format + ": must be auto, grey, nv12, yuyv or mjpeg");
  if (!arguments.size.empty() && !calibrated.empty())
    throw UsageError("--camera-size: the calibration says how large the pictures are");

  V4l2Options options;
  options.assemble.rate_hz = pulse_rate_hz;
  if (rig.capture.deadline_ms > 0.0) options.assemble.deadline_s = rig.capture.deadline_ms * 1e-3;
  // A camera that was behind makes the others wait by so many pulses once it is corrected.
  if (rig.sync.code_seed != 0) options.assemble.most_sets_waiting += CodeAlignment::kMostSlip;
  options.feed.on_event = print_event;
  for (std::size_t n = 0; n < named.size(); ++n) {
    CameraRequest camera;
    camera.name = named[n].name;
    camera.device = named[n].device;
    camera.format.kind = kind;
    if (!calibrated.empty()) camera.format.size = {calibrated[n].width_px, calibrated[n].height_px};
    if (!arguments.size.empty()) camera.format.size = size_of(arguments.size);
    camera.format.rate_hz = rig.capture.rate_hz > 0.0 ? rig.capture.rate_hz : pulse_rate_hz;
    camera.controls = controls_of(rig, camera.name);
    camera.pulse_rate_hz = pulse_rate_hz;
    options.cameras.push_back(std::move(camera));
  }
  return options;
}

}  // namespace glint::apps
