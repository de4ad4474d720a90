// SPDX-License-Identifier: MIT
// What a long command is doing, on standard error.
#pragma once

#include <string>

namespace glint::apps {

/// Rewrites its line on a terminal, writes a line for each step elsewhere.
class ProgressLine {
 public:
  explicit ProgressLine(bool quiet);
  ~ProgressLine();  ///< clears the line
  ProgressLine(const ProgressLine&) = delete;
  ProgressLine& operator=(const ProgressLine&) = delete;

  void show(const std::string& text);

 private:
  bool quiet_ = false, terminal_ = false, open_ = false;
};

}  // namespace glint::apps
