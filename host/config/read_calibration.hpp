// SPDX-License-Identifier: MIT
// The calibration part of a parsed file; private to host/config.
#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "host/config/toml_section.hpp"
#include "host/geometry/camera.hpp"

namespace glint {

enum class FileKind : std::uint8_t { Rig, Calibration, Bodies };

/// Reads `format` and `kind`. Nothing, and a problem, if this program does not know them: the rest of the
/// file cannot be judged then.
std::optional<FileKind> read_header(TomlSection& top, FileProblems& problems);

/// Reads the keys of a calibration file below its header. Incomplete if `problems` is not empty afterwards.
Calibration read_cameras(TomlSection& top, FileProblems& problems);

/// Reads the text of a calibration file.
Calibration parse_calibration(std::string_view text, FileProblems& problems);

/// Why a string cannot be a camera's name; empty if it can. Names become file and folder names.
std::string problem_of_camera_name(std::string_view name);

}  // namespace glint
