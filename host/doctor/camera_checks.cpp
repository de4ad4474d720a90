// SPDX-License-Identifier: MIT
// Compares what drivers offer with what is wanted.
#include "host/doctor/camera_checks.hpp"

#include <grp.h>
#include <sys/stat.h>

#include <cstdio>
#include <filesystem>
#include <system_error>

namespace glint {
namespace {

namespace fs = std::filesystem;

/// "group video may, with mode 0660"; "" if the node is not there.
std::string who_may(const std::string& node) {
  struct stat info {};
  if (stat(node.c_str(), &info) != 0) return "";
  const group* const owner = getgrgid(info.st_gid);
  char mode[8];
  std::snprintf(mode, sizeof mode, "%04o", static_cast<unsigned>(info.st_mode & 07777));
  return std::string("it belongs to the group ") +
         (owner != nullptr ? owner->gr_name : std::to_string(info.st_gid).c_str()) + ", mode " + mode;
}

std::string stem(const DeviceIdentity& identity) {
  return identity.node + (identity.by_path.empty() ? "" : " (" + identity.by_path + ")");
}

Finding unusable(const CameraInfo& camera) {
  Finding finding{"cameras", Verdict::Problem, stem(camera.identity) + ": " + camera.problem, ""};
  const std::string who = who_may(camera.identity.node);
  if (who.empty()) {
    finding.advice =
        "the kernel knows the camera, but its node is not there: in a container, pass it on "
        "(--device " +
        camera.identity.node + ")";
  } else {
    finding.advice = who +
                     "; run `id` to see your groups, and close programs that use the camera "
                     "(fuser " +
                     camera.identity.node + ")";
  }
  return finding;
}

std::string wanted_text(const WantedFormat& wanted) {
  char rate[32] = "";
  if (wanted.rate_hz > 0.0) std::snprintf(rate, sizeof rate, " at %.4g Hz", wanted.rate_hz);
  return (wanted.kind ? std::string(name_of(*wanted.kind)) : "any format") + " " +
         std::to_string(wanted.size.width_px) + "x" + std::to_string(wanted.size.height_px) + rate;
}

Finding check_one(DeviceCalls& calls, const DeviceRoots& roots, const CameraRequest& wanted) {
  Finding finding{"rig", Verdict::Ok, "camera " + wanted.name + ": ", ""};
  try {
    OpenCamera opened = open_camera(calls, roots, wanted.device);
    finding.text += opened.identity.node;
    std::vector<FormatOffer> formats = list_formats(opened.node);
    std::string controls;
    const std::vector<CameraControl> known =
        wanted.controls.empty() ? std::vector<CameraControl>() : list_controls(opened.node);
    for (const ControlSetting& setting : wanted.controls) {
      const std::string problem = setting_problem(known, setting);
      if (!problem.empty()) controls += "; " + problem;
    }
    if (const auto kind = format_for(formats, wanted.format)) {
      WantedFormat taken = wanted.format;
      taken.kind = kind;
      finding.text += " offers " + wanted_text(taken);
    } else {
      std::erase_if(formats, [](const FormatOffer& format) { return !format.kind; });
      finding.verdict = Verdict::Problem;
      finding.text += " does not list " + wanted_text(wanted.format);
      finding.advice = "it lists " + describe(formats) +
                       ": set capture.format or capture.rate_hz, or calibrate for a size that it has";
    }
    if (!controls.empty()) {
      finding.verdict = Verdict::Problem;
      finding.text += controls;
      finding.advice += (finding.advice.empty() ? "" : "; ") +
                        std::string("set capture.controls to what glint devices lists");
    }
  } catch (const NoSuchCamera& error) {
    finding = {"rig", Verdict::Problem, finding.text + error.what(),
               "plug it in, or give its device in [[capture.camera]] as glint devices prints it"};
  } catch (const Error& error) {
    finding = {"rig", Verdict::Problem, finding.text + error.what(), "see the line on cameras"};
  }
  return finding;
}

}  // namespace

Findings check_cameras(const CameraList& list, const DeviceRoots& roots) {
  if (list.cameras.empty()) {
    std::error_code error;
    const bool driver = fs::exists(roots.sys / "class" / "video4linux", error);
    return {
        {"cameras", Verdict::Problem, "no camera is connected",
         driver ? "plug one in; lsusb shows whether USB sees it, dmesg whether a driver takes it"
                : "this kernel has no video device at all: plug a camera in, and see with lsusb whether USB "
                  "knows it and with `modprobe uvcvideo` whether its driver is there; a container or virtual "
                  "machine must be given the device"}};
  }
  Findings findings;
  std::string usable;
  for (const CameraInfo& camera : list.cameras) {
    if (!camera.problem.empty()) {
      // The other nodes of a device that may not be opened are metadata, as often as not.
      if (camera.identity.index == 0) findings.push_back(unusable(camera));
    } else {
      usable += (usable.empty() ? "" : ", ") + camera.identity.node;
    }
  }
  if (!usable.empty())
    findings.insert(findings.begin(), {"cameras", Verdict::Ok, usable + " can be opened", ""});
  return findings;
}

std::optional<PixelKind> format_for(const std::vector<FormatOffer>& formats, const WantedFormat& wanted) {
  for (const PixelKind kind : kKindsInOrder) {
    if (wanted.kind && *wanted.kind != kind) continue;
    for (const FormatOffer& format : formats) {
      if (format.kind == kind && offers(format, wanted.size, wanted.rate_hz)) return kind;
    }
  }
  return std::nullopt;
}

Findings check_wanted(DeviceCalls& calls, const DeviceRoots& roots,
                      const std::vector<CameraRequest>& wanted) {
  Findings findings;
  findings.reserve(wanted.size());
  for (const CameraRequest& camera : wanted) findings.push_back(check_one(calls, roots, camera));
  return findings;
}

}  // namespace glint
