// SPDX-License-Identifier: MIT
// Adds up what the cameras of each bus send.
//
// USB 2.0 specification, 5.6.3 and 5.6.4: isochronous transfers get at most 80 % of a 125 us microframe (7500
// bytes at 480 Mbit/s), and one endpoint at most 3 x 1024 bytes of it. uvcvideo reserves what the camera asks
// for, which for MJPEG is often the most it can, whatever it will send.
#include "host/doctor/usb_checks.hpp"

#include <cstdio>
#include <map>
#include <set>
#include <string>

#include "host/doctor/camera_checks.hpp"

namespace glint {
namespace {

constexpr double kHighSpeed_mbit_s = 480.0;
constexpr double kShareOfBus = 0.8;
constexpr double kMostOfOneCamera_bit_s = 3 * 1024 * 8 * 8000.0;  // 197 Mbit/s, high speed only
// Simulated frames of 1280x800 with sensor noise have 0.16 at quality 80, 0.31 at 90, 0.78 at 95.
constexpr double kMjpegBitsAPixel = 0.8;

struct Load {
  std::vector<const CameraInfo*> cameras;
  std::set<std::string> ports;
  double bit_s = 0.0;  // of those that the rig wants
  std::string too_much;
};

std::string text_of(double bit_s) {
  char text[32];
  std::snprintf(text, sizeof text, "%.0f Mbit/s", bit_s * 1e-6);
  return text;
}

/// What the rig will have this camera send; 0 if it is not of the rig or offers nothing that fits.
double wanted_bit_s(const CameraInfo& camera, const DeviceRoots& roots,
                    const std::vector<CameraRequest>& wanted) {
  for (const CameraRequest& request : wanted) {
    if (!means(request.device, camera.identity, roots)) continue;
    const auto kind = format_for(camera.formats, request.format);
    return kind ? stream_bit_s(*kind, request.format.size, request.format.rate_hz) : 0.0;
  }
  return 0.0;
}

Finding check_bus(unsigned bus, const Load& load, bool rig_known) {
  const double speed_mbit_s = load.cameras.front()->identity.usb->speed_mbit_s;
  const double room_bit_s = kShareOfBus * speed_mbit_s * 1e6;
  std::string nodes;
  for (const CameraInfo* camera : load.cameras) nodes += (nodes.empty() ? "" : ", ") + camera->identity.node;
  Finding finding{"usb", Verdict::Ok, "bus " + std::to_string(bus) + ": " + nodes, ""};
  if (rig_known)
    finding.text += ", about " + text_of(load.bit_s) + " of " + text_of(room_bit_s) + " for such transfers";
  if (!load.too_much.empty() || (speed_mbit_s > 0.0 && load.bit_s > room_bit_s)) {
    finding.verdict = Verdict::Problem;
    finding.text += load.too_much.empty() ? ": too much" : "; too much for one camera: " + load.too_much;
    finding.advice =
        "use mjpeg (capture.format), a lower rate, or a USB 3 camera; or spread the cameras over "
        "several host controllers (lsusb -t; a PCIe card with one controller for each port)";
  } else if (load.ports.size() > 1 && speed_mbit_s <= kHighSpeed_mbit_s) {
    finding.verdict = Verdict::Warning;
    finding.text += "; they share it";
    finding.advice =
        "cameras reserve more than they send: should one fail to start with \"no bandwidth left\", "
        "move it to another host controller (lsusb -t)";
  }
  return finding;
}

}  // namespace

double stream_bit_s(PixelKind kind, FrameSize size, double rate_hz) noexcept {
  const double pixels_s = static_cast<double>(size.width_px) * size.height_px * rate_hz;
  switch (kind) {
    case PixelKind::Grey:
      return 8.0 * pixels_s;
    case PixelKind::Nv12:
      return 12.0 * pixels_s;
    case PixelKind::Yuyv:
      return 16.0 * pixels_s;
    case PixelKind::Mjpeg:
      break;
  }
  return kMjpegBitsAPixel * pixels_s;
}

Findings check_usb(const CameraList& list, const DeviceRoots& roots,
                   const std::vector<CameraRequest>& wanted) {
  std::map<unsigned, Load> buses;
  for (const CameraInfo& camera : list.cameras) {
    if (!camera.identity.usb) continue;
    Load& load = buses[camera.identity.usb->bus];
    load.cameras.push_back(&camera);
    load.ports.insert(camera.identity.usb->port);
    const double bit_s = wanted_bit_s(camera, roots, wanted);
    load.bit_s += bit_s;
    if (camera.identity.usb->speed_mbit_s <= kHighSpeed_mbit_s && bit_s > kMostOfOneCamera_bit_s)
      load.too_much += (load.too_much.empty() ? "" : ", ") + camera.identity.node + " " + text_of(bit_s);
  }
  Findings findings;
  for (const auto& [bus, load] : buses) findings.push_back(check_bus(bus, load, !wanted.empty()));
  return findings;
}

}  // namespace glint
