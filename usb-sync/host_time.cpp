// SPDX-License-Identifier: MIT
#include "usb-sync/host_time.hpp"

#include <cmath>
#include <cstdio>

namespace glint::sync {

std::string time_text(Seconds time) {
  struct Unit {
    double seconds;
    const char* name;
  };
  constexpr Unit kUnits[] = {{1.0, "s"}, {1e-3, "ms"}, {1e-6, "us"}, {1e-9, "ns"}};
  constexpr double kRounding = 1.0 - 1e-9;  // 299.9999999 us / 1 us is still 300 us, 1e-3 s is 1 ms
  const double size = std::abs(time.count());
  const Unit* unit = &kUnits[3];
  for (const Unit& candidate : kUnits) {
    if (size >= candidate.seconds * kRounding) {
      unit = &candidate;
      break;
    }
  }
  char text[40];
  std::snprintf(text, sizeof text, "%.6g %s", time.count() / unit->seconds, size == 0.0 ? "s" : unit->name);
  return text;
}

}  // namespace glint::sync
