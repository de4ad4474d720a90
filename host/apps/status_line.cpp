// SPDX-License-Identifier: MIT
// The live line.
#include "host/apps/status_line.hpp"

#include <unistd.h>

#include <cstdio>

namespace glint::apps {

StatusLine::StatusLine(bool quiet) : quiet_(quiet), terminal_(isatty(STDERR_FILENO) == 1) {}

StatusLine::~StatusLine() {
  if (open_) std::fputc('\n', stderr);
}

bool StatusLine::due(Timestamp now) noexcept {
  if (quiet_ || now < next_) return false;
  const bool first = next_ == Timestamp{};
  next_ = now + std::chrono::seconds(1);
  return !first;
}

void StatusLine::show(const Status& s) {
  std::fprintf(
      stderr,
      "%s%7.1f s  %6.1f Hz  %5.1f points  detection %.2f ms  %s %.2f ms (p99 %.2f)  missed %llu%s%s%s",
      terminal_ ? "\r" : "", s.since_start_s, s.rate_hz, s.points_per_tick, s.detection_p50_s * 1e3,
      s.from_stamp ? "stamp to output" : "end to end", s.latency_p50_s * 1e3, s.latency_p99_s * 1e3,
      static_cast<unsigned long long>(s.missed), s.not_used.empty() ? "" : "  no frame: ", s.not_used.c_str(),
      terminal_ ? "  " : "\n");
  std::fflush(stderr);
  open_ = terminal_;
}

}  // namespace glint::apps
