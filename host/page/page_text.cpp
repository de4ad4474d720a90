// SPDX-License-Identifier: MIT
// Numbers and words as they stand on a page.
#include "host/page/page_text.hpp"

#include <array>
#include <charconv>
#include <cmath>

namespace glint {

double round_step(double extent, double wanted) {
  if (!(extent > 0) || !std::isfinite(extent)) return 1.0;
  const double raw = extent / wanted, power = std::pow(10.0, std::floor(std::log10(raw)));
  const double lead = raw / power;
  return power * (lead < 1.5 ? 1.0 : lead < 3.5 ? 2.0 : lead < 7.5 ? 5.0 : 10.0);
}

std::string short_number(double value, int most_decimals) {
  if (!std::isfinite(value)) return "?";
  std::array<char, 400> digits{};
  const auto end = std::to_chars(digits.data(), digits.data() + digits.size(), value,
                                 std::chars_format::fixed, most_decimals);
  std::string s(digits.data(), end.ptr);
  if (s.find('.') != std::string::npos) {
    s.erase(s.find_last_not_of('0') + 1);
    if (s.back() == '.') s.pop_back();
  }
  return s == "-0" ? "0" : s;
}

std::string escape_html(std::string_view text) {
  std::string s;
  s.reserve(text.size());
  for (const char c : text) {
    switch (c) {
      case '&':
        s += "&amp;";
        break;
      case '<':
        s += "&lt;";
        break;
      case '>':
        s += "&gt;";
        break;
      case '"':
        s += "&quot;";
        break;
      default:
        s += c;
    }
  }
  return s;
}

}  // namespace glint
