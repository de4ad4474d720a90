// SPDX-License-Identifier: MIT
// Options of the form A:B:C, like CAMERA:TICK:DEGREES.
#pragma once

#include <charconv>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

namespace glint::apps {

/// The parts of one such option. Everything throws UsageError with option, text, form and example if the text
/// is of another form.
class ColonList {
 public:
  /// `option` like "--bump"; `form` like "CAMERA:TICK:DEGREES"; `example` like "2:450:0.5".
  ColonList(std::string option, std::string text, std::string form, std::string example);

  /// Index from 0 of the camera that people number from 1.
  std::uint32_t camera(std::size_t part) const;
  template <typename Number>
  Number number(std::size_t part) const {
    Number value{};
    const std::string_view text = parts_[part];
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
    if (error != std::errc() || end != text.data() + text.size()) refuse();
    return value;
  }

 private:
  [[noreturn]] void refuse() const;

  std::string option_, text_, form_, example_;
  std::vector<std::string> parts_;
};

}  // namespace glint::apps
