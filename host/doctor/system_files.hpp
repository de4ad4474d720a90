// SPDX-License-Identifier: MIT
// Reading the small text files in which Linux tells about itself.
#pragma once

#include <filesystem>
#include <optional>
#include <string>

namespace glint {

/// The first line without blanks at its end; nothing if the file cannot be read.
std::optional<std::string> first_line(const std::filesystem::path& file);

}  // namespace glint
