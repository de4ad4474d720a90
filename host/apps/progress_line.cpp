// SPDX-License-Identifier: MIT
// One line at a time.
#include "host/apps/progress_line.hpp"

#include <unistd.h>

#include <cstdio>

namespace glint::apps {
namespace {

constexpr const char* kClearLine = "\r\x1b[K";

}  // namespace

ProgressLine::ProgressLine(bool quiet) : quiet_(quiet), terminal_(isatty(STDERR_FILENO) == 1) {}

ProgressLine::~ProgressLine() {
  if (open_) std::fputs(kClearLine, stderr);
}

void ProgressLine::show(const std::string& text) {
  if (quiet_) return;
  std::fprintf(stderr, "%sglint: %s%s", terminal_ ? kClearLine : "", text.c_str(), terminal_ ? "" : "\n");
  std::fflush(stderr);
  open_ = terminal_;
}

}  // namespace glint::apps
