// SPDX-License-Identifier: MIT
// How the programs of this folder end.
#pragma once

namespace glint::device {

/// Exit code of `run`; what it throws goes to standard error after `name`: 2 for a UsageError, else 1.
int run_program(const char* name, int (*run)(int argc, char** argv), int argc, char** argv) noexcept;

}  // namespace glint::device
