// SPDX-License-Identifier: MIT
// Everything a run needs to know about a rig, as its file says it, and the files themselves
// (docs/rig-file.md).
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "gpu/detector.hpp"
#include "host/body/body_model.hpp"
#include "host/geometry/camera.hpp"
#include "host/match/matcher.hpp"
#include "host/track/tracker.hpp"

namespace glint {

/// Section [detect].
struct DetectSettings {
  unsigned threshold = 12;  ///< grey levels above the background: ten times the noise of a dark pixel of a
                            ///< raw 8-bit camera; what it cuts off the edge of a blob costs accuracy
  unsigned background_frames = 30;  ///< frames that the background is learnt from (their median); 0: none
  std::uint32_t min_area_px = 2;    ///< one bright pixel alone is a hot pixel more often than a marker
  std::uint32_t max_area_px = static_cast<std::uint32_t>(gpu::kMaxPixels);  ///< default: no limit
  std::uint32_t max_blobs_per_camera = 8192;             ///< room; more is flagged as overflow and counted
  void check(std::vector<std::string>& problems) const;  ///< appends "detect.threshold must be ...", ...
};

/// Section [gpu].
struct GpuSettings {
  std::string device = "auto";  ///< "auto", "cpu", an index, a UUID or part of a device's name
  unsigned depth = 1;           ///< frame sets in flight: 1 least delay, 2 most throughput
  void check(std::vector<std::string>& problems) const;
};

/// A control of a camera: "gain" and a number, or a menu's item by name.
struct ControlValue {
  std::string name;
  std::variant<std::int64_t, std::string> value;
};

/// Section [[capture.camera]]: which device is which camera of the calibration.
struct CaptureCamera {
  std::string name;                    ///< the calibration's
  std::string device;                  ///< by-path name, "usb:1-2.3", "serial:ABC" or a path
  std::vector<ControlValue> controls;  ///< set after those of all cameras
};

/// Section [capture]: live cameras. Their picture size is the calibration's.
struct CaptureSettings {
  std::string format = "auto";  ///< "auto", "grey", "nv12", "yuyv" or "mjpeg"
  double rate_hz = 0.0;  ///< what the cameras' drivers are set to; 0: rig.rate_hz. More where a trigger sets
                         ///< the pace and a camera offers only some rates
  double deadline_ms = 0.0;            ///< how long a frame set waits for its last camera; 0: half a period
  std::vector<ControlValue> controls;  ///< of all cameras, in the order of the file
  std::vector<CaptureCamera> cameras;
  void check(std::vector<std::string>& problems) const;
};

/// Section [[sync.output]]: an output of the sync board that is not as the others of its kind.
struct SyncOutput {
  std::uint32_t output = 0;  ///< 0 to 3: triggers, 4 to 7: strobes
  bool enabled = true, active_low = false;
  std::optional<double> delay_us, width_us;  ///< none: as the others of its kind
  std::uint32_t every_n = 1, phase = 0;      ///< fires in pulses whose number % every_n is phase
};

/// Section [sync]: the sync board (docs/sync-board.md) and its coded pulses (host/base/pulse_code.hpp).
struct SyncSettings {
  std::string board = "none";  ///< "none"; "auto": if there is one; else its serial number
  bool follow = false;         ///< somebody else starts and stops it
  double trigger_us = 100.0, trigger_delay_us = 0.0;
  double strobe_us = 137.0, strobe_delay_us = 788.0;  ///< when the Arducam B0332 exposes, in its trigger mode
  std::uint32_t keepalive_ms = 2000;                  ///< without glint the board stops; 0: it goes on
  bool sync_out = false;
  std::vector<SyncOutput> outputs;
  std::uint32_t code_seed = 0;   ///< as the sync board has it; 0: the light is never off on purpose
  std::uint32_t code_group = 0;  ///< pulses for each dark one; 0: as recommended for the rate
  void check(std::vector<std::string>& problems) const;
};

/// One rig file with its calibration. A Rig that read_rig() returned is complete and within range.
struct Rig {
  std::string name = "rig";
  double rate_hz = 90.0;         ///< nominal frame sets per second
  double marker_radius_m = 0.0;  ///< 0: unknown; equals match.marker_radius_m
  Calibration calibration;
  GpuSettings gpu;
  DetectSettings detect;
  MatchOptions match;
  TrackOptions track;
  SyncSettings sync;
  CaptureSettings capture;
  std::vector<BodyModel> bodies;  ///< sections [[body]], in their order
  std::filesystem::path path;     ///< the file it was read from; empty: defaults
  std::filesystem::path
      calibration_path;  ///< where its cameras came from; equals path for a calibration file alone
};

/// Files larger than this are refused.
inline constexpr std::size_t kMaxConfigFileBytes = 1'000'000;

/// Reads a rig file with the calibration it names, or a calibration file alone (the rest are defaults).
/// Throws glint::Error with every problem of both files, one line each: "file:line:column: text".
Rig read_rig(const std::filesystem::path& path);

/// Reads a calibration file. Throws as read_rig() does.
Calibration read_calibration(const std::filesystem::path& path);

/// Writes a calibration file that read_calibration() gives back bit for bit (rotations must be unit
/// quaternions). The file appears whole or not at all. Throws glint::Error if it exists and `force` is false,
/// if it cannot be written, or if the calibration is one that read_calibration() would refuse.
void write_calibration(const std::filesystem::path& path, const Calibration& calibration, bool force = false);

/// Whether a rig file stands there, however faulty: what must not be overwritten by anything smaller.
bool is_rig_file(const std::filesystem::path& path);

/// The text of such a file. Does not check.
std::string to_toml(const Calibration& calibration);

/// The rig as a rig file with every key written out; the cameras follow as comments, and the calibration is
/// named by its absolute path.
std::string to_toml(const Rig& rig);

}  // namespace glint
