// SPDX-License-Identifier: MIT
// Small text files: read whole, written whole or not at all.
#pragma once

#include <cstddef>
#include <filesystem>
#include <string>
#include <string_view>

namespace glint {

/// The bytes of a file. Throws glint::Error ("FILE: cannot be read: ...") if it is missing, a folder,
/// unreadable or larger than `max_bytes`.
std::string read_text_file(const std::filesystem::path& path, std::size_t max_bytes);

/// Writes a temporary file in the same folder and renames it, so that nobody sees half a file. Throws
/// glint::Error if the file exists and `force` is false, or if anything fails; the old file is then
/// untouched.
void write_text_file(const std::filesystem::path& path, std::string_view text, bool force);

}  // namespace glint
