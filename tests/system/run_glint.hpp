// SPDX-License-Identifier: MIT
// Runs the built `glint` as a person would and keeps what it says.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace glint::test {

struct Outcome {
  int exit_code = -1;  ///< 128 + signal when it was killed
  std::string out, err;
};

struct RunOptions {
  std::vector<std::string> environment;  ///< NAME=VALUE, added to this process's
  double interrupt_after_s = 0.0;        ///< send SIGINT then; 0: never
  std::string program{};                 ///< another build of glint; else the usual one
  std::string standard_output;           ///< a file that takes it, such as /dev/full; else it is captured
};

/// Arguments are passed as they are, without a shell.
Outcome run_glint(const std::vector<std::string>& arguments, const RunOptions& options = {});

}  // namespace glint::test
