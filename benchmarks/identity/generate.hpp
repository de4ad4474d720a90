// SPDX-License-Identifier: MIT
// A scene for other trackers: blobs, calibration, truth.
#pragma once

#include <filesystem>

#include "benchmarks/identity/scene_file.hpp"

namespace glint::identity {

/// Writes FOLDER/blobs/CAMERA.csv (as `glint track blobs:FOLDER/blobs` reads them), calibration.toml (with
/// the scene's error), truth.csv and scene.json (last: where it is, the rest is whole). The folder must be
/// new or empty. Throws Error.
void generate(const ChosenScene& chosen, const std::filesystem::path& folder);

}  // namespace glint::identity
