// SPDX-License-Identifier: MIT
// Exceptions to exit codes.
#include "tests/device/program/program.hpp"

#include <cstdio>
#include <exception>

#include "host/base/error.hpp"

namespace glint::device {

int run_program(const char* name, int (*run)(int argc, char** argv), int argc, char** argv) noexcept {
  try {
    return run(argc, argv);
  } catch (const UsageError& error) {
    std::fprintf(stderr, "%s: %s\n", name, error.what());
    return 2;
  } catch (const std::exception& error) {
    std::fprintf(stderr, "%s: %s\n", name, error.what());
    return 1;
  }
}

}  // namespace glint::device
