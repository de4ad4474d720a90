// SPDX-License-Identifier: MIT
// Numbers as text, the same in every locale.
#pragma once

#include <optional>
#include <string>
#include <string_view>

namespace glint {

/// The whole of `text` as a finite number; nothing otherwise. Blanks around it and a leading + are allowed.
std::optional<double> parse_number(std::string_view text);

/// The shortest text that gives the same double back, always with a point or an exponent (TOML tells 1
/// from 1.0).
std::string exact_text(double value);

/// Few digits, for messages.
std::string short_text(double value);

}  // namespace glint
