// SPDX-License-Identifier: MIT
// What `glint track --output csv:FILE` wrote, read back.
#pragma once

#include <filesystem>
#include <vector>

#include "host/body/learn.hpp"

namespace glint::apps {

/// One entry per tick that has points, in the order of the file; points that were not measured (column
/// `kind`, where there is one) are left out. Columns are found by their names in the first line. Throws Error
/// with file, line and column.
std::vector<RecordedTick> read_recorded_tracks(const std::filesystem::path& path);

}  // namespace glint::apps
