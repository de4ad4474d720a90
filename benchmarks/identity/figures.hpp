// SPDX-License-Identifier: MIT
// The figures of the benchmark by name: how each is read from a result and written for people.
#pragma once

#include <span>
#include <string>
#include <string_view>

#include "host/sim/identity_score.hpp"

namespace glint::identity {

struct Figure {
  std::string_view name;  ///< as goals, JSON and the command line have it
  std::string_view title, unit;
  double shown_per_si;  ///< "mm": 1000
  int decimals;
  bool more_is_better;
  double (*of)(const IdentityResult& result);
};

std::span<const Figure> figures() noexcept;
/// Throws std::out_of_range for a name that is none.
const Figure& figure(std::string_view name);
/// "0.035 mm"; infinity is a word.
std::string shown(const Figure& figure, double value, bool with_unit = true);

}  // namespace glint::identity
