// SPDX-License-Identifier: MIT
// What was odd about a source, as text for the person at the terminal.
#pragma once

#include <cstddef>
#include <string>
#include <utility>
#include <vector>

namespace glint {

/// Lines of text; the first few of them in words, the rest as a number.
class Notes {
 public:
  /// One of possibly very many.
  void add(std::string line) {
    if (events_.size() < kShown) {
      events_.push_back(std::move(line));
    } else {
      ++unsaid_;
    }
    rebuild();
  }
  /// Always shown.
  void add_summary(std::string line) {
    summary_.push_back(std::move(line));
    rebuild();
  }
  const std::string& text() const noexcept { return text_; }

 private:
  void rebuild() {
    text_.clear();
    const auto append = [this](const std::string& line) { text_ += (text_.empty() ? "" : "\n") + line; };
    for (const std::string& line : events_) append(line);
    if (unsaid_ > 0) append("and " + std::to_string(unsaid_) + " more like these");
    for (const std::string& line : summary_) append(line);
  }
  static constexpr std::size_t kShown = 12;
  std::vector<std::string> events_, summary_;
  std::size_t unsaid_ = 0;
  std::string text_;
};

}  // namespace glint
