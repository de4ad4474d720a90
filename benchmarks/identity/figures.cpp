// SPDX-License-Identifier: MIT
// One row for each figure.
#include "benchmarks/identity/figures.hpp"

#include <array>
#include <cmath>
#include <cstdio>
#include <stdexcept>

namespace glint::identity {
namespace {

double number_of(std::uint64_t count) noexcept { return static_cast<double>(count); }

using Result = const IdentityResult&;
constexpr std::array kFigures{
    Figure{"recall", "recall", "", 1.0, 5, true, [](Result r) { return r.recall; }},
    Figure{"ghosts_per_tick", "ghosts", "per frame", 1.0, 4, false,
           [](Result r) { return r.ghosts_per_tick; }},
    Figure{"doubled_per_tick", "doubles", "per frame", 1.0, 4, false,
           [](Result r) { return r.doubled_per_tick; }},
    Figure{"mixed", "mixed points", "", 1.0, 0, false, [](Result r) { return number_of(r.mixed); }},
    Figure{"silent_swaps", "silent swaps", "", 1.0, 0, false,
           [](Result r) { return number_of(r.ids.silent_swaps); }},
    Figure{"swaps", "swaps", "", 1.0, 0, false, [](Result r) { return number_of(r.ids.swaps); }},
    Figure{"fragments", "fragments", "", 1.0, 0, false, [](Result r) { return number_of(r.ids.fragments); }},
    Figure{"returns", "returns", "", 1.0, 0, false, [](Result r) { return number_of(r.ids.returns); }},
    Figure{"longest_gap", "longest gap", "frames", 1.0, 0, false,
           [](Result r) { return number_of(r.longest_gap_frames); }},
    Figure{"rms", "RMS", "mm", 1e3, 4, false, [](Result r) { return r.rms_m; }},
    Figure{"worst", "worst error", "mm", 1e3, 2, false, [](Result r) { return r.worst_m; }},
    Figure{"median", "median error", "mm", 1e3, 4, false, [](Result r) { return r.median_m; }},
    Figure{"q999", "99.9 % error", "mm", 1e3, 3, false, [](Result r) { return r.q999_m; }},
    Figure{"pair_rms", "distance RMS", "mm", 1e3, 4, false, [](Result r) { return r.pair_rms_m; }},
    Figure{"pair_worst", "distance worst", "mm", 1e3, 2, false, [](Result r) { return r.pair_worst_m; }},
    Figure{"ambiguous_share", "ambiguous", "%", 1e2, 3, false, [](Result r) { return r.ambiguous_share; }},
    Figure{"predicted_share", "predicted", "%", 1e2, 3, false, [](Result r) { return r.predicted_share; }},
    Figure{"predicted_rms", "RMS of predicted", "mm", 1e3, 2, false,
           [](Result r) { return r.predicted_rms_m; }},
    Figure{"nees", "NEES", "", 1.0, 3, false, [](Result r) { return r.nees.mean; }},
    Figure{"nees_low", "NEES 2.5 %", "", 1.0, 3, false, [](Result r) { return r.nees.low; }},
    Figure{"nees_high", "NEES 97.5 %", "", 1.0, 3, false, [](Result r) { return r.nees.high; }},
    Figure{"nees_outside", "1 outside of NEES band by", "", 1.0, 3, false,
           [](Result r) { return r.nees_outside(); }},
    Figure{"recovery", "recovery", "frames", 1.0, 0, false,
           [](Result r) { return number_of(r.recovery_frames); }},
    Figure{"expected", "expected", "", 1.0, 0, true, [](Result r) { return number_of(r.expected); }},
};

}  // namespace

std::span<const Figure> figures() noexcept { return kFigures; }

const Figure& figure(std::string_view name) {
  for (const Figure& known : kFigures)
    if (known.name == name) return known;
  throw std::out_of_range("no figure " + std::string(name));
}

std::string shown(const Figure& figure, double value, bool with_unit) {
  if (std::isinf(value)) return "infinite";
  char text[64];
  std::snprintf(text, sizeof text, "%.*f", figure.decimals, value * figure.shown_per_si);
  std::string result = text;
  if (with_unit && !figure.unit.empty()) result += " " + std::string(figure.unit);
  return result;
}

}  // namespace glint::identity
