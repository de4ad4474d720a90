// SPDX-License-Identifier: MIT
// The folder of real recordings that some tests read.
#pragma once

#include <cstdint>
#include <cstdlib>
#include <filesystem>
#include <iostream>
#include <optional>
#include <string>

namespace glint::test {

/// A recording in the folder that GLINT_TEST_DATA names; nothing, said aloud, if it is not there.
inline std::optional<std::filesystem::path> test_data(const std::string& recording) {
  const char* const root = std::getenv("GLINT_TEST_DATA");
  if (root != nullptr && std::filesystem::exists(std::filesystem::path(root) / recording)) {
    return std::filesystem::path(root) / recording;
  }
  std::cout << "SKIPPED: no " << recording << " in GLINT_TEST_DATA (" << (root != nullptr ? root : "not set")
            << ")\n";
  return std::nullopt;
}

/// A copy in which bytes were put in or lost is no basis for a verdict on the reader.
inline bool is_intact(const std::filesystem::path& folder, const std::string& extension,
                      std::uintmax_t total_bytes) {
  std::uintmax_t bytes = 0;
  for (const auto& entry : std::filesystem::recursive_directory_iterator(folder)) {
    if (entry.path().extension() == extension) bytes += entry.file_size();
  }
  if (bytes == total_bytes) return true;
  std::cout << "SKIPPED: " << folder << " holds " << bytes << " bytes of " << extension << ", the original "
            << total_bytes << ": this copy is damaged\n";
  return false;
}

}  // namespace glint::test
