// SPDX-License-Identifier: MIT
// The times that the host's side of the sync board speaks of.
#pragma once

#include <chrono>
#include <string>

namespace glint::sync {

/// A length of time; 137us, 11ms or Seconds(1.0 / 90.0) all convert to it.
using Seconds = std::chrono::duration<double>;

/// CLOCK_MONOTONIC, the clock that cameras' frames are stamped with.
using HostClock = std::chrono::steady_clock;
using HostTime = HostClock::time_point;

/// For people: "8 ns", "137 us", "11.1111 ms", "2 s".
std::string time_text(Seconds time);

}  // namespace glint::sync
