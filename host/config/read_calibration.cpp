// SPDX-License-Identifier: MIT
// Calibration files: TOML to structs.
#include "host/config/read_calibration.hpp"

#include <algorithm>
#include <cmath>
#include <map>

#include "host/config/number_text.hpp"
#include "host/config/rig.hpp"
#include "host/files/text_file.hpp"

namespace glint {
namespace {

constexpr std::uint32_t kMaxSidePx = 65'535;
/// A quaternion written with four digits passes; one that was mistyped does not.
constexpr double kQuaternionTolerance = 1e-3;
/// Closer than this to unit length is rounding of a unit quaternion, which is kept bit for bit.
constexpr double kQuaternionRounding = 1e-14;

Pose read_pose(TomlSection& camera, const std::string& camera_name, FileProblems& problems) {
  Pose pose;
  const toml::table* table = camera.table("world_from_camera", Need::Required);
  if (!table) return pose;
  TomlSection section(*table, camera_name + ".world_from_camera", problems);
  Eigen::Vector3d& t = pose.translation;
  section.number("x_m", t.x(), Need::Required);
  section.number("y_m", t.y(), Need::Required);
  section.number("z_m", t.z(), Need::Required);
  Eigen::Vector4d q = Eigen::Vector4d::Zero();
  bool complete = section.number("qx", q[0], Need::Required);
  complete &= section.number("qy", q[1], Need::Required);
  complete &= section.number("qz", q[2], Need::Required);
  complete &= section.number("qw", q[3], Need::Required);
  section.finish();
  if (!complete) return pose;
  const double length = q.stableNorm();
  if (length == 0.0) {
    camera.problem("world_from_camera", "has the quaternion 0 0 0 0, which is no rotation (none: qw = 1)");
  } else if (!(std::abs(length - 1.0) <= kQuaternionTolerance)) {
    camera.problem("world_from_camera", "has a quaternion of length " + short_text(length) +
                                            "; a rotation has length 1 (within " +
                                            short_text(kQuaternionTolerance) + ")");
  } else {
    pose.rotation.coeffs() = q;
    if (std::abs(q.squaredNorm() - 1.0) > kQuaternionRounding) pose.rotation.normalize();
  }
  return pose;
}

CameraCalibration read_camera(const toml::table& table, std::size_t number, FileProblems& problems) {
  const std::string prefix = "camera " + std::to_string(number);
  TomlSection section(table, prefix, problems);
  CameraCalibration camera;
  if (section.text("name", camera.name, Need::Required)) {
    const std::string problem = problem_of_camera_name(camera.name);
    if (!problem.empty()) section.problem("name", problem);
  }
  bool sized = section.whole("width_px", camera.width_px, 1, kMaxSidePx, Need::Required);
  sized &= section.whole("height_px", camera.height_px, 1, kMaxSidePx, Need::Required);
  if (sized && std::uint64_t{camera.width_px} * camera.height_px > gpu::kMaxPixels) {
    section.problem("width_px",
                    "times height_px must be at most " + std::to_string(gpu::kMaxPixels) + " pixels");
  }
  if (section.number("fx_px", camera.fx_px, Need::Required) && camera.fx_px == 0.0) {
    section.problem("fx_px", "must not be 0");
  }
  if (section.number("fy_px", camera.fy_px, Need::Required) && camera.fy_px == 0.0) {
    section.problem("fy_px", "must not be 0");
  }
  section.number("cx_px", camera.cx_px, Need::Required);
  section.number("cy_px", camera.cy_px, Need::Required);
  section.numbers("k1_k2_p1_p2_k3", camera.k1_k2_p1_p2_k3, Need::Required);
  if (section.numbers("intrinsics_sd", camera.intrinsics_sd, Need::Optional) &&
      *std::min_element(camera.intrinsics_sd.begin(), camera.intrinsics_sd.end()) < 0.0) {
    section.problem("intrinsics_sd", "must not be negative (all 0: unknown)");
  }
  camera.world_from_camera = read_pose(section, prefix, problems);
  if (section.number("rms_px", camera.rms_px, Need::Optional) && camera.rms_px < 0.0) {
    section.problem("rms_px", "must not be negative (0: unknown)");
  }
  section.finish();
  return camera;
}

void check_names_differ(const Calibration& calibration, const toml::array& tables, FileProblems& problems) {
  std::map<std::string, std::size_t> first;
  for (std::size_t n = 0; n < calibration.cameras.size(); ++n) {
    const std::string& name = calibration.cameras[n].name;
    if (name.empty()) continue;
    const auto [entry, is_new] = first.emplace(name, n);
    if (is_new) continue;
    const toml::node* node = tables[n].as_table()->get("name");
    problems.add(node->source().begin, "camera " + std::to_string(n + 1) + ".name \"" + name +
                                           "\" is taken by camera " + std::to_string(entry->second + 1));
  }
}

}  // namespace

std::string problem_of_camera_name(std::string_view name) {
  if (name.empty()) return "must not be empty";
  if (name.size() > 64) return "must be at most 64 bytes long";
  if (name == "." || name == "..") return "must not be . or .. (it becomes a folder's name)";
  for (const char c : name) {
    const auto byte = static_cast<unsigned char>(c);
    if (byte < 0x20 || byte == 0x7f) return "must not contain control characters";
    if (c == '/' || c == '\\' || c == ',' || c == '"') {
      return std::string("must not contain ") + c + " (it becomes a folder's name and a CSV field)";
    }
  }
  return "";
}

std::optional<FileKind> read_header(TomlSection& top, FileProblems& problems) {
  std::uint32_t format = 0;
  std::string kind;
  bool known = true;
  if (!top.whole("format", format, 0, 0xffffffffu, Need::Required)) {
    known = false;
  } else if (format != 1) {
    problems.add(top.where("format"), "format " + std::to_string(format) +
                                          " is unknown; this program reads format 1" +
                                          (format > 1 ? " (the file is of a newer glint)" : ""));
    known = false;
  }
  if (!top.text("kind", kind, Need::Required)) return std::nullopt;
  if (kind != "rig" && kind != "calibration" && kind != "bodies") {
    top.problem("kind", "must be \"rig\", \"calibration\" or \"bodies\", not \"" + kind + "\"");
    return std::nullopt;
  }
  if (!known) return std::nullopt;
  if (kind == "bodies") return FileKind::Bodies;
  return kind == "rig" ? FileKind::Rig : FileKind::Calibration;
}

Calibration read_cameras(TomlSection& top, FileProblems& problems) {
  Calibration calibration;
  top.text("made_at", calibration.made_at, Need::Optional);
  top.text("made_from", calibration.made_from, Need::Optional);
  const toml::array* tables = top.tables("camera", Need::Optional);
  if (tables) {
    for (const toml::node& node : *tables) {
      calibration.cameras.push_back(read_camera(*node.as_table(), calibration.cameras.size() + 1, problems));
    }
    check_names_differ(calibration, *tables, problems);
    if (tables->size() > gpu::kMaxCameras) {
      problems.add((*tables)[gpu::kMaxCameras].source().begin,
                   std::to_string(tables->size()) + " cameras; at most " + std::to_string(gpu::kMaxCameras) +
                       " are supported");
    }
  }
  if (calibration.cameras.empty() && (tables || !top.has("camera"))) {
    problems.add(top.where("camera"), "no camera; add a [[camera]] section for each");
  }
  top.finish();
  return calibration;
}

Calibration parse_calibration(std::string_view text, FileProblems& problems) {
  const auto table = parse_toml(text, problems);
  if (!table) return {};
  TomlSection top(*table, "", problems);
  const auto kind = read_header(top, problems);
  if (!kind) return {};
  if (*kind != FileKind::Calibration) {
    top.problem("kind", std::string("is \"") + (*kind == FileKind::Rig ? "rig" : "bodies") +
                            "\"; here a calibration file is wanted");
    return {};
  }
  return read_cameras(top, problems);
}

Calibration read_calibration(const std::filesystem::path& path) {
  FileProblems problems(path);
  Calibration calibration = parse_calibration(read_text_file(path, kMaxConfigFileBytes), problems);
  throw_problems(problems.lines());
  return calibration;
}

}  // namespace glint
