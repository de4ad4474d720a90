// SPDX-License-Identifier: MIT
// What the format readers of import_calibration() find, before it is judged; private to host/config.
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include <Eigen/Core>

namespace glint {

/// One camera as its file has it. Rotation and translation are camera_from_world: X_cam = R X_world + t.
struct RawCamera {
  std::string where;                          ///< "file:line:column" or the like, for messages
  std::string name;                           ///< empty: the file has none
  std::uint32_t width_px = 0, height_px = 0;  ///< 0: the file does not say
  Eigen::Matrix3d matrix = Eigen::Matrix3d::Identity();
  std::vector<double> distortion;  ///< OpenCV's order, any length
  std::optional<Eigen::Matrix3d> rotation;
  std::optional<Eigen::Vector3d> translation;  ///< in the file's unit
  double rms_px = 0.0;
};

struct RawCalibration {
  std::string format;  ///< for made_from
  std::vector<RawCamera> cameras;
  std::optional<double> metres_per_unit;  ///< nothing: the format does not say
  std::vector<std::string> notes;
};

struct InputFile {
  std::filesystem::path path;
  std::string text;
};

/// "file:line:column" of a byte.
std::string place_of(const InputFile& file, std::size_t offset);

/// Rotation matrix of a Rodrigues vector (axis times angle in radians).
Eigen::Matrix3d rotation_of_vector(const Eigen::Vector3d& rodrigues);

/// A whole number of pixels from 1 to 65535. Throws Error beginning with `where` otherwise.
std::uint32_t pixels_of(double value, const std::string& where);

RawCalibration read_json_calibration(const std::vector<InputFile>& files);
RawCalibration read_opencv_calibration(const std::vector<InputFile>& files);
RawCalibration read_openlpt_calibration(const std::vector<InputFile>& files);
/// aniposelib and caliscope; `caliscope` decides the unit where the file itself does not show which one it
/// is.
RawCalibration read_toml_calibration(const std::vector<InputFile>& files, std::optional<bool> caliscope);

}  // namespace glint
