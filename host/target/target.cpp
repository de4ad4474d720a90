// SPDX-License-Identifier: MIT
#include "host/target/target.hpp"

#include <charconv>
#include <cmath>

#include "host/base/error.hpp"

namespace glint {
namespace {

std::string shortest(double value) {
  char text[32];
  return {text, std::to_chars(text, text + sizeof text, value).ptr};
}

}  // namespace

Target marker_target(double marker_radius_m) {
  Target target;
  target.marker_radius_m = marker_radius_m;
  target.name = "marker";
  return target;
}

Target wand_target(const std::vector<double>& places_m, double marker_radius_m) {
  const auto fail = [&](const std::string& what) {
    std::string places;
    for (double place : places_m) places += (places.empty() ? "" : ",") + shortest(place);
    throw UsageError("wand " + places + ": " + what);
  };
  if (places_m.size() < 2 || places_m.size() > 3)
    fail("must have two or three markers: their distances from the first in metres, like 0,0.13,0.39");
  if (places_m.front() != 0.0) fail("the first marker's place must be 0");
  for (std::size_t i = 1; i < places_m.size(); ++i) {
    if (!std::isfinite(places_m[i]) || places_m[i] - places_m[i - 1] < 0.01)
      fail("each marker must lie at least 0.01 m beyond the one before it");
  }
  if (places_m.back() > 10.0) fail("longer than 10 m: places are in metres");
  if (places_m.size() == 3) {
    const double a = places_m[1], b = places_m[2] - places_m[1];
    // Nearer to each other, a wand that is held steeply looks as if it were the other way round.
    constexpr double kLeastRatio = 1.499;
    if (std::max(a, b) < kLeastRatio * std::min(a, b))
      fail("one spacing must be at least one and a half times the other, or the ends cannot be told apart");
  }
  Target target;
  target.kind = TargetKind::Wand;
  target.marker_radius_m = marker_radius_m;
  target.points_in_target.clear();
  target.name = "wand:";
  for (double place : places_m) {
    target.name += (target.points_in_target.empty() ? "" : ",") + shortest(place);
    target.points_in_target.emplace_back(place, 0.0, 0.0);
  }
  return target;
}

}  // namespace glint
