// SPDX-License-Identifier: MIT
// The folder of real recordings that some tests read.
#pragma once

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

}  // namespace glint::test
