// SPDX-License-Identifier: MIT
// One line at a time.
#include "host/doctor/system_files.hpp"

#include <fstream>

namespace glint {

std::optional<std::string> first_line(const std::filesystem::path& file) {
  std::ifstream in(file);
  std::string line;
  if (!std::getline(in, line)) return std::nullopt;
  line.erase(line.find_last_not_of(" \t\r") + 1);
  return line;
}

}  // namespace glint
