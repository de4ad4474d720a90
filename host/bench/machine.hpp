// SPDX-License-Identifier: MIT
// The computer, as it describes itself.
#pragma once

#include <optional>
#include <string>

#include "host/bench/results.hpp"

namespace glint::bench {

/// From /proc, /etc/os-release, uname and sysfs. What cannot be read is left empty.
Machine describe_machine();

/// How long cores of this computer were busy since it started, with anybody's work, in core seconds; nothing
/// where /proc/stat does not tell.
std::optional<double> busy_core_s();

/// "2026-01-31T12:00:00Z"
std::string utc_now();

}  // namespace glint::bench
