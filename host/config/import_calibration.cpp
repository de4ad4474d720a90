// SPDX-License-Identifier: MIT
// Other tools' calibration files to a Calibration: guesses the format, then judges and converts what its
// reader found.
#include "host/config/import_calibration.hpp"

#include <Eigen/SVD>
#include <algorithm>
#include <cmath>
#include <set>

#include "gpu/detector.hpp"
#include "host/base/error.hpp"
#include "host/config/number_text.hpp"
#include "host/config/raw_calibration.hpp"
#include "host/config/read_calibration.hpp"
#include "host/config/rig.hpp"
#include "host/files/text_file.hpp"

namespace glint {
namespace {

/// Files carry six digits or more; a matrix that is this far off was damaged or is something else.
constexpr double kRotationTolerance = 1e-3;

std::optional<CalibrationFormat> guess_format(const std::string& text) {
  const auto has = [&](std::string_view part) { return text.find(part) != std::string::npos; };
  const auto first = text.find_first_not_of(" \t\r\n\xEF\xBB\xBF");
  if (first == std::string::npos) return std::nullopt;
  if (text[first] == '{') return CalibrationFormat::Json;
  if (text[first] == '<' || text.compare(first, 5, "%YAML") == 0 || has("!!opencv-matrix")) {
    return CalibrationFormat::OpenCv;
  }
  if (has("# Camera Model")) return CalibrationFormat::OpenLpt;
  if (has("[cameras.")) return CalibrationFormat::Caliscope;
  if (has("[cam_") || has("[[camera]]")) return CalibrationFormat::Anipose;
  if (has("camera_matrix:") || has("cameraMatrix:")) return CalibrationFormat::OpenCv;
  return std::nullopt;
}

CalibrationFormat format_of(const std::vector<InputFile>& files, CalibrationFormat wanted) {
  if (wanted != CalibrationFormat::Guess) return wanted;
  const auto guess = guess_format(files.front().text);
  if (!guess) {
    throw Error(files.front().path.string() +
                ": not a calibration format that is known here (json, opencv, anipose, caliscope, openlpt)");
  }
  return *guess;
}

RawCalibration read_raw(const std::vector<InputFile>& files, CalibrationFormat wanted) {
  switch (format_of(files, wanted)) {
    case CalibrationFormat::Json:
      return read_json_calibration(files);
    case CalibrationFormat::OpenCv:
      return read_opencv_calibration(files);
    case CalibrationFormat::OpenLpt:
      return read_openlpt_calibration(files);
    case CalibrationFormat::Anipose:
    case CalibrationFormat::Caliscope:
    case CalibrationFormat::Guess:
      break;
  }
  if (wanted == CalibrationFormat::Guess) return read_toml_calibration(files, std::nullopt);
  return read_toml_calibration(files, wanted == CalibrationFormat::Caliscope);
}

void take_intrinsics(const RawCamera& raw, CameraCalibration& camera) {
  const Eigen::Matrix3d& k = raw.matrix;
  if (!k.allFinite()) throw Error(raw.where + ": the camera matrix holds a number that is not finite");
  const double scale = std::max(std::abs(k(0, 0)), std::abs(k(1, 1)));
  if (k(0, 0) == 0.0 || k(1, 1) == 0.0)
    throw Error(raw.where + ": the camera matrix has a focal length of 0");
  if (k(1, 0) != 0.0 || k(2, 0) != 0.0 || k(2, 1) != 0.0 || k(2, 2) != 1.0) {
    throw Error(raw.where + ": the camera matrix must have the form fx s cx, 0 fy cy, 0 0 1");
  }
  if (std::abs(k(0, 1)) > 1e-9 * scale) {
    throw Error(raw.where + ": the camera matrix has a skew of " + short_text(k(0, 1)) +
                ", which glint's camera model lacks; calibrate without skew");
  }
  camera.fx_px = k(0, 0);
  camera.fy_px = k(1, 1);
  camera.cx_px = k(0, 2);
  camera.cy_px = k(1, 2);
}

void take_distortion(const RawCamera& raw, CameraCalibration& camera) {
  const auto& d = raw.distortion;
  if (!std::all_of(d.begin(), d.end(), [](double v) { return std::isfinite(v); })) {
    throw Error(raw.where + ": a distortion coefficient is not finite");
  }
  if (d.size() >= 1 && d.size() <= 3) {
    throw Error(raw.where + ": " + std::to_string(d.size()) +
                " distortion coefficients; there must be 4 (k1 k2 p1 p2), 5 (and k3) or none");
  }
  for (std::size_t n = 5; n < d.size(); ++n) {
    if (d[n] == 0.0) continue;
    throw Error(
        raw.where + ": " + std::to_string(d.size()) + " distortion coefficients, of which number " +
        std::to_string(n + 1) + " is " + short_text(d[n]) +
        "; glint's model has the first five (k1 k2 p1 p2 k3): calibrate without the rational, thin-prism "
        "and tilted models");
  }
  std::copy_n(d.begin(), std::min<std::size_t>(d.size(), 5), camera.k1_k2_p1_p2_k3.begin());
}

Eigen::Quaterniond nearest_rotation(const Eigen::Matrix3d& matrix, const std::string& where) {
  const double off = (matrix.transpose() * matrix - Eigen::Matrix3d::Identity()).cwiseAbs().maxCoeff();
  if (!(off <= kRotationTolerance)) {
    throw Error(where + ": the rotation is none: R^T R differs from the identity by " + short_text(off) +
                " (allowed: " + short_text(kRotationTolerance) + ")");
  }
  if (matrix.determinant() < 0.0) {
    throw Error(where + ": the rotation is mirrored (its determinant is -1): one axis is turned round");
  }
  const Eigen::JacobiSVD<Eigen::Matrix3d> svd(matrix, Eigen::ComputeFullU | Eigen::ComputeFullV);
  return Eigen::Quaterniond(Eigen::Matrix3d(svd.matrixU() * svd.matrixV().transpose())).normalized();
}

void take_pose(const RawCamera& raw, const std::optional<double>& metres_per_unit,
               CameraCalibration& camera) {
  if (!raw.translation->allFinite()) throw Error(raw.where + ": the translation is not finite");
  const bool at_origin = raw.translation->isZero(0.0);
  if (!metres_per_unit && !at_origin) {
    throw Error(
        raw.where +
        ": this format does not say in which unit positions are; say it with --unit mm (or cm, m, inch)");
  }
  const Pose camera_from_world{nearest_rotation(*raw.rotation, raw.where),
                               *raw.translation * (at_origin ? 1.0 : *metres_per_unit)};
  camera.world_from_camera = camera_from_world.inverse();
}

void take_size(const RawCamera& raw, const ImportOptions& options, CameraCalibration& camera) {
  const bool given = options.width_px > 0 && options.height_px > 0;
  const bool found = raw.width_px > 0 && raw.height_px > 0;
  if (!given && !found) {
    throw Error(raw.where + ": the file does not tell the size of the image; add --size WIDTHxHEIGHT");
  }
  camera.width_px = found ? raw.width_px : options.width_px;
  camera.height_px = found ? raw.height_px : options.height_px;
  if (given && (camera.width_px != options.width_px || camera.height_px != options.height_px)) {
    throw Error(raw.where + ": the file says " + std::to_string(raw.width_px) + "x" +
                std::to_string(raw.height_px) + ", --size says " + std::to_string(options.width_px) + "x" +
                std::to_string(options.height_px) + "; a calibration holds for one size only");
  }
}

/// The file's name for the camera, else the stem of a file that holds one camera, else cam1, cam2, ...
std::string name_of(const RawCalibration& raw, std::size_t number, const std::vector<InputFile>& files,
                    const ImportOptions& options) {
  if (!options.names.empty()) return options.names[number];
  const std::string& name = raw.cameras[number].name;
  if (!name.empty()) return name;
  if (files.size() == raw.cameras.size()) return files[number].path.stem().string();
  return "cam" + std::to_string(number + 1);
}

void check_names(const std::vector<CameraCalibration>& cameras) {
  std::set<std::string> seen;
  for (const CameraCalibration& camera : cameras) {
    const std::string problem = problem_of_camera_name(camera.name);
    if (!problem.empty()) {
      throw Error("camera name \"" + camera.name + "\" " + problem + "; choose names with --names");
    }
    if (!seen.insert(camera.name).second) {
      throw Error("two cameras are called \"" + camera.name + "\"; choose names with --names");
    }
  }
}

/// Whether poses are there; without any, each camera is its own world, and that is said.
bool have_poses(const RawCalibration& raw, std::vector<std::string>& notes) {
  std::size_t with = 0;
  for (const RawCamera& camera : raw.cameras) with += camera.rotation && camera.translation ? 1u : 0u;
  for (const RawCamera& camera : raw.cameras) {
    if ((camera.rotation && camera.translation) || with == 0) continue;
    throw Error(camera.where + ": this camera has no pose (rotation and translation), but others have");
  }
  if (with == 0) {
    notes.push_back(raw.cameras.size() == 1
                        ? "no pose in the file: the world is the camera's own frame"
                        : "no poses in the files: all cameras stand at the origin, so that images can be "
                          "undistorted but nothing can be triangulated");
  }
  return with > 0;
}

}  // namespace

std::optional<CalibrationFormat> calibration_format_of(std::string_view word) {
  if (word == "json") return CalibrationFormat::Json;
  if (word == "opencv") return CalibrationFormat::OpenCv;
  if (word == "anipose") return CalibrationFormat::Anipose;
  if (word == "caliscope") return CalibrationFormat::Caliscope;
  if (word == "openlpt") return CalibrationFormat::OpenLpt;
  return std::nullopt;
}

std::string place_of(const InputFile& file, std::size_t offset) {
  const std::string_view before = std::string_view(file.text).substr(0, offset);
  const auto line = std::count(before.begin(), before.end(), '\n') + 1;
  const auto newline = before.rfind('\n');
  const std::size_t column = before.size() - (newline == std::string_view::npos ? 0 : newline + 1) + 1;
  return file.path.string() + ":" + std::to_string(line) + ":" + std::to_string(column);
}

Eigen::Matrix3d rotation_of_vector(const Eigen::Vector3d& rodrigues) {
  const double angle = rodrigues.norm();
  if (angle == 0.0) return Eigen::Matrix3d::Identity();
  return Eigen::AngleAxisd(angle, rodrigues / angle).toRotationMatrix();
}

std::uint32_t pixels_of(double value, const std::string& where) {
  if (!(value >= 1.0 && value <= 65'535.0 && value == std::floor(value))) {
    throw Error(where + ": the image size must be whole numbers from 1 to 65535, not " + short_text(value));
  }
  return static_cast<std::uint32_t>(value);
}

Calibration import_calibration(const std::vector<std::filesystem::path>& paths, const ImportOptions& options,
                               std::vector<std::string>* notes) {
  if (paths.empty()) throw Error("no calibration file to import");
  std::vector<InputFile> files;
  for (const auto& path : paths) files.push_back({path, read_text_file(path, kMaxConfigFileBytes)});
  RawCalibration raw = read_raw(files, options.format);
  if (raw.cameras.empty()) throw Error(files.front().path.string() + ": there is no camera in it");
  if (raw.cameras.size() > gpu::kMaxCameras) {
    throw Error(files.front().path.string() + ": " + std::to_string(raw.cameras.size()) +
                " cameras; at most " + std::to_string(gpu::kMaxCameras) + " are supported");
  }
  if (!options.names.empty() && options.names.size() != raw.cameras.size()) {
    throw Error("--names gives " + std::to_string(options.names.size()) + " names for " +
                std::to_string(raw.cameras.size()) + " cameras");
  }
  const auto unit = options.metres_per_unit ? options.metres_per_unit : raw.metres_per_unit;
  if (unit && !(std::isfinite(*unit) && *unit > 0.0)) {
    throw Error("the unit of length must be > 0 metres, not " + short_text(*unit));
  }

  Calibration calibration;
  const bool posed = have_poses(raw, raw.notes);
  for (std::size_t n = 0; n < raw.cameras.size(); ++n) {
    CameraCalibration camera;
    camera.name = name_of(raw, n, files, options);
    take_size(raw.cameras[n], options, camera);
    take_intrinsics(raw.cameras[n], camera);
    take_distortion(raw.cameras[n], camera);
    if (posed) take_pose(raw.cameras[n], unit, camera);
    const double rms_px = raw.cameras[n].rms_px;
    camera.rms_px = std::isfinite(rms_px) && rms_px > 0.0 ? rms_px : 0.0;
    calibration.cameras.push_back(std::move(camera));
  }
  check_names(calibration.cameras);
  calibration.made_from = raw.format + ":";
  for (const InputFile& file : files) calibration.made_from.append(" ").append(file.path.filename().string());
  if (notes) notes->insert(notes->end(), raw.notes.begin(), raw.notes.end());
  return calibration;
}

}  // namespace glint
