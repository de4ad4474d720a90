// SPDX-License-Identifier: MIT
// Numbers and words as they stand on a page.
#pragma once

#include <string>
#include <string_view>

namespace glint {

/// A round step (1, 2 or 5 times a power of ten) that divides `extent` into about `wanted` parts.
double round_step(double extent, double wanted);
/// As few digits as say the value: "0.5", "12", "1.25".
std::string short_number(double value, int most_decimals = 6);
std::string escape_html(std::string_view text);

}  // namespace glint
