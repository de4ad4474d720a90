// SPDX-License-Identifier: MIT
// Other tools' calibration files to a Calibration.
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "host/geometry/camera.hpp"

namespace glint {

enum class CalibrationFormat : std::uint8_t {
  Guess,      ///< from the content
  Json,       ///< list of cameras with K, R, t (X_cam = R X_world + t)
  OpenCv,     ///< OpenCV FileStorage, YAML or XML; one camera a file, or a stereo pair
  Anipose,    ///< aniposelib TOML
  Caliscope,  ///< caliscope TOML
  OpenLpt,    ///< OpenLPT camera text, one camera a file
};

/// "json", "opencv", "anipose", "caliscope", "openlpt"; nothing for other words.
std::optional<CalibrationFormat> calibration_format_of(std::string_view word);

struct ImportOptions {
  CalibrationFormat format = CalibrationFormat::Guess;
  /// Length of the files' unit. Needed where positions are given and the format does not say their unit
  /// (OpenCV, aniposelib); overrides what it says otherwise.
  std::optional<double> metres_per_unit;
  std::vector<std::string>
      names;  ///< one per camera in file order; empty: the files' names, else file stems or cam1..
  std::uint32_t width_px = 0, height_px = 0;  ///< for cameras whose file does not tell their image size
};

/// Reads one or more files of one format. Rotation matrices must be rotations within 1e-3 and are replaced by
/// the nearest exact one. Pixels of all formats count the centre of the top-left pixel as (0,0), as glint
/// does; nothing is shifted. `made_at` stays empty. Appends to `notes` what the person at the terminal should
/// know (cameras left out, poses missing). Throws glint::Error naming file and, where the format's reader
/// tells, line and column.
Calibration import_calibration(const std::vector<std::filesystem::path>& files, const ImportOptions& options,
                               std::vector<std::string>* notes = nullptr);

}  // namespace glint
