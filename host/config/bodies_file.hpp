// SPDX-License-Identifier: MIT
// Rigid bodies in files: sections [[body]] of a rig file, and body files that hold nothing else.
#pragma once

#include <filesystem>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "host/body/body_model.hpp"

namespace glint {

class FileProblems;
class TomlSection;

/// Reads a body file, or the [[body]] sections of a rig file. Throws glint::Error with every problem, one
/// line each: "file:line:column: text", also if there is no body.
std::vector<BodyModel> read_bodies(const std::filesystem::path& path);

/// Writes a body file that read_bodies() gives back bit for bit. The file appears whole or not at all. Throws
/// glint::Error if it exists and `force` is false, if it is a rig file, or if it could not be read back.
void write_bodies(const std::filesystem::path& path, std::span<const BodyModel> bodies, bool force = false);

/// The text of such a file. Does not check.
std::string to_toml(std::span<const BodyModel> bodies);

/// One [[body]] section.
std::string body_section(const BodyModel& body);

/// The [[body]] sections of a file's top; none is no problem.
std::vector<BodyModel> read_body_sections(TomlSection& top, FileProblems& problems);

}  // namespace glint
