// SPDX-License-Identifier: MIT
// What is thrown before the loop runs: one line for the person at the terminal.
#pragma once

#include <stdexcept>

namespace glint {

/// Something outside the program is wrong (exit code 1). The text names the file, line or device and
/// what to do.
class Error : public std::runtime_error {
  using std::runtime_error::runtime_error;
};

/// The command line is wrong (exit code 2).
class UsageError : public Error {
  using Error::Error;
};

}  // namespace glint
