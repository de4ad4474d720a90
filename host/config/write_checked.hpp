// SPDX-License-Identifier: MIT
// Files that glint writes for itself to read.
#pragma once

#include <filesystem>
#include <functional>
#include <string>
#include <string_view>

#include "host/config/toml_section.hpp"

namespace glint {

/// Writes `text` if `parse` finds nothing wrong with it; throws Error otherwise. An existing file is replaced
/// only with `force`, and a rig file never: it says much more than this. `instead` tells the person what to
/// do about that.
void write_checked(const std::filesystem::path& path, const std::string& text,
                   const std::function<void(std::string_view, FileProblems&)>& parse,
                   const std::string& instead, bool force);

}  // namespace glint
