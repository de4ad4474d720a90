// SPDX-License-Identifier: MIT
// Rig files: TOML to structs. A new setting is read here, in its section's function.
#include <cstdint>
#include <limits>
#include <string>
#include <system_error>
#include <utility>
#include <vector>

#include "host/base/error.hpp"
#include "host/config/bodies_file.hpp"
#include "host/config/number_text.hpp"
#include "host/config/read_calibration.hpp"
#include "host/config/read_capture.hpp"
#include "host/config/read_sync.hpp"
#include "host/config/rig.hpp"
#include "host/config/toml_section.hpp"
#include "host/files/text_file.hpp"

namespace glint {
namespace {

constexpr std::uint32_t kAnyCount = std::numeric_limits<std::uint32_t>::max();
constexpr double kMaxRateHz = 10'000.0;
constexpr double kMaxMarkerRadius = 1.0;

/// Places what an option struct's check() says ("detect.min_area_px must ...") at the key it speaks of.
void place(const std::vector<std::string>& complaints, const std::string& section_name, TomlSection& section,
           FileProblems& problems) {
  for (const std::string& complaint : complaints) {
    const auto blank = complaint.find(' ');
    const std::string prefix = section_name + ".";
    const bool names_key = blank != std::string::npos && complaint.rfind(prefix, 0) == 0;
    const std::string key = names_key ? complaint.substr(prefix.size(), blank - prefix.size()) : "";
    problems.add(section.where(key), complaint);
  }
}

/// Reads one optional section by `read`, then asks the option struct whether the result makes sense.
template <typename Options, typename Read>
void read_section(TomlSection& top, const std::string& name, Options& options, FileProblems& problems,
                  const Read& read) {
  const toml::table* table = top.table(name, Need::Optional);
  if (!table) return;
  TomlSection section(*table, name, problems);
  read(section);
  section.finish();
  std::vector<std::string> complaints;
  options.check(complaints);
  place(complaints, name, section, problems);
}

void read_rig_section(TomlSection& top, Rig& rig, FileProblems& problems,
                      std::vector<std::string>& calibration_problems) {
  const toml::table* table = top.table("rig", Need::Required);
  if (!table) return;
  TomlSection section(*table, "rig", problems);
  if (section.text("name", rig.name, Need::Required) && rig.name.empty()) {
    section.problem("name", "must not be empty");
  }
  if (section.number("rate_hz", rig.rate_hz, Need::Required) &&
      !(rig.rate_hz > 0.0 && rig.rate_hz <= kMaxRateHz)) {
    section.problem("rate_hz",
                    "must be > 0 and <= " + short_text(kMaxRateHz) + ", not " + short_text(rig.rate_hz));
  }
  if (section.number("marker_radius_m", rig.marker_radius_m, Need::Optional) &&
      !(rig.marker_radius_m >= 0.0 && rig.marker_radius_m <= kMaxMarkerRadius)) {
    section.problem("marker_radius_m", "must be 0 (unknown) to " + short_text(kMaxMarkerRadius) + ", not " +
                                           short_text(rig.marker_radius_m) + "; it is in metres");
    rig.marker_radius_m = 0.0;
  }
  rig.match.marker_radius_m = rig.marker_radius_m;
  std::string calibration;
  if (section.text("calibration", calibration, Need::Required)) {
    if (calibration.empty()) {
      section.problem("calibration", "must name a calibration file");
    } else {
      rig.calibration_path = (rig.path.parent_path() / calibration).lexically_normal();
      try {
        FileProblems found(rig.calibration_path);
        rig.calibration = parse_calibration(read_text_file(rig.calibration_path, kMaxConfigFileBytes), found);
        calibration_problems = found.lines();
      } catch (const Error& error) {
        section.problem("calibration", std::string("cannot be used: ") + error.what());
      }
    }
  }
  section.finish();
}

Rig read_rig_tables(TomlSection& top, const std::filesystem::path& path, FileProblems& problems,
                    std::vector<std::string>& calibration_problems) {
  Rig rig;
  rig.path = path;
  read_rig_section(top, rig, problems, calibration_problems);
  read_section(top, "gpu", rig.gpu, problems, [&](TomlSection& section) {
    section.text("device", rig.gpu.device, Need::Optional);
    section.whole("depth", rig.gpu.depth, 0, kAnyCount, Need::Optional);
  });
  read_section(top, "detect", rig.detect, problems, [&](TomlSection& section) {
    section.whole("threshold", rig.detect.threshold, 0, kAnyCount, Need::Optional);
    section.whole("background_frames", rig.detect.background_frames, 0, kAnyCount, Need::Optional);
    section.whole("min_area_px", rig.detect.min_area_px, 0, kAnyCount, Need::Optional);
    section.whole("max_area_px", rig.detect.max_area_px, 0, kAnyCount, Need::Optional);
    section.whole("max_blobs_per_camera", rig.detect.max_blobs_per_camera, 0, kAnyCount, Need::Optional);
  });
  read_section(top, "match", rig.match, problems, [&](TomlSection& section) {
    section.number("sigma_px", rig.match.sigma_px, Need::Optional);
    section.number("gate_px", rig.match.gate_px, Need::Optional);
    section.number("exposure_s", rig.match.exposure_s, Need::Optional);
    section.whole("most_looks", rig.match.most_looks, 0, kAnyCount, Need::Optional);
    section.number("min_range_m", rig.match.min_range_m, Need::Optional);
    section.number("max_range_m", rig.match.max_range_m, Need::Optional);
    double plane_height_m = 0.0;
    if (section.number("plane_height_m", plane_height_m, Need::Optional))
      rig.match.plane_height_m = plane_height_m;
    const std::size_t cameras = rig.calibration.cameras.size();
    if (rig.match.plane_height_m && cameras > 1) {
      section.problem("plane_height_m", "is for a rig of one camera, and the calibration has " +
                                            std::to_string(cameras) +
                                            ": leave it out, several cameras measure heights themselves");
    }
    if (section.whole("min_cameras", rig.match.min_cameras, 0, kAnyCount, Need::Optional) && cameras > 0 &&
        rig.match.min_cameras > cameras && !rig.match.plane_height_m) {
      section.problem("min_cameras",
                      "is more than the " + std::to_string(cameras) + " cameras of the calibration");
    }
  });
  read_section(top, "track", rig.track, problems, [&](TomlSection& section) {
    section.number("acceleration_sd_m_s2", rig.track.acceleration_sd_m_s2, Need::Optional);
    section.number("max_speed_m_s", rig.track.max_speed_m_s, Need::Optional);
    section.whole("confirm_frames_two_views", rig.track.confirm_frames_two_views, 0, kAnyCount,
                  Need::Optional);
    section.number("max_predicted_sd_m", rig.track.max_predicted_sd_m, Need::Optional);
    section.whole("max_missed_frames", rig.track.max_missed_frames, 0, kAnyCount, Need::Optional);
  });
  read_section(top, "sync", rig.sync, problems,
               [&](TomlSection& section) { read_sync(section, rig.sync, problems); });
  read_section(top, "capture", rig.capture, problems,
               [&](TomlSection& section) { read_capture(section, rig.calibration, rig.capture, problems); });
  rig.bodies = read_body_sections(top, problems);
  top.finish();
  return rig;
}

}  // namespace

void DetectSettings::check(std::vector<std::string>& problems) const {
  const auto require = [&](bool fine, const std::string& text) {
    if (!fine) problems.push_back("detect." + text);
  };
  require(threshold <= 254, "threshold must be 0 to 254 grey levels, not " + std::to_string(threshold));
  require(background_frames <= 1000,
          "background_frames must be 0 (none) to 1000, not " + std::to_string(background_frames));
  require(
      min_area_px >= 1 && min_area_px <= gpu::kMaxPixels,
      "min_area_px must be 1 to " + std::to_string(gpu::kMaxPixels) + ", not " + std::to_string(min_area_px));
  require(max_area_px >= min_area_px, "max_area_px must be at least min_area_px (" +
                                          std::to_string(min_area_px) + "), not " +
                                          std::to_string(max_area_px));
  require(max_blobs_per_camera >= 1 && max_blobs_per_camera <= 65'536,
          "max_blobs_per_camera must be 1 to 65536, not " + std::to_string(max_blobs_per_camera));
}

void GpuSettings::check(std::vector<std::string>& problems) const {
  if (device.empty()) problems.emplace_back("gpu.device must not be empty (\"auto\" chooses one)");
  if (depth < 1 || depth > 4) problems.push_back("gpu.depth must be 1 to 4, not " + std::to_string(depth));
}

Rig read_rig(const std::filesystem::path& path) {
  const std::string text = read_text_file(path, kMaxConfigFileBytes);
  FileProblems problems(path);
  std::vector<std::string> calibration_problems;
  Rig rig;
  if (const auto table = parse_toml(text, problems)) {
    TomlSection top(*table, "", problems);
    const auto kind = read_header(top, problems);
    if (kind == FileKind::Rig) {
      rig = read_rig_tables(top, path, problems, calibration_problems);
    } else if (kind == FileKind::Calibration) {
      rig.calibration = read_cameras(top, problems);
      rig.path = rig.calibration_path = path;
      if (path.has_stem()) rig.name = path.stem().string();
    } else if (kind == FileKind::Bodies) {
      top.problem("kind", "is \"bodies\"; here a rig or calibration file is wanted");
    }
  }
  std::vector<std::string> lines = problems.lines();
  lines.insert(lines.end(), calibration_problems.begin(), calibration_problems.end());
  throw_problems(lines);
  return rig;
}

}  // namespace glint
