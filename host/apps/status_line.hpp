// SPDX-License-Identifier: MIT
// One line on standard error that says how the run goes.
#pragma once

#include <cstdint>
#include <string>

#include "host/base/ids.hpp"

namespace glint::apps {

struct Status {
  double since_start_s = 0.0, rate_hz = 0.0;
  double points_per_tick = 0.0;
  double detection_p50_s = 0.0;
  bool from_stamp = false;  ///< the latency is that from the driver's stamp to the output, else end to end
  double latency_p50_s = 0.0, latency_p99_s = 0.0;
  std::uint64_t missed = 0;
  std::string not_used;  ///< "cam1 3, cam4 12": pulses without a frame that was used; "" if none
};

/// Rewrites its line on a terminal, writes one line a second elsewhere.
class StatusLine {
 public:
  explicit StatusLine(bool quiet);
  ~StatusLine();  ///< ends the line
  StatusLine(const StatusLine&) = delete;
  StatusLine& operator=(const StatusLine&) = delete;

  /// True once a second: time for show().
  bool due(Timestamp now) noexcept;
  void show(const Status& status);

 private:
  bool quiet_ = false, terminal_ = false, open_ = false;
  Timestamp next_{};
};

}  // namespace glint::apps
