// SPDX-License-Identifier: MIT
// What a check found, and what to do about it.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

namespace glint {

enum class Verdict : std::uint8_t {
  Ok,
  Warning,  ///< live capture works, worse than it could
  Problem,  ///< live capture does not work
};

struct Finding {
  std::string check;  ///< a word: "cameras"
  Verdict verdict = Verdict::Ok;
  std::string text;    ///< what was found, in a line
  std::string advice;  ///< what to do; "" if nothing
};

using Findings = std::vector<Finding>;

}  // namespace glint
