// SPDX-License-Identifier: MIT
// `--realtime` and `--pin`.
#pragma once

#include <optional>
#include <string>

#include <CLI/CLI.hpp>

#include "host/apps/run_arguments.hpp"
#include "host/realtime/real_time.hpp"

namespace glint::apps {

struct RealTimeArguments {
  std::string mode, cpus;  ///< as written; "" if not given
};

void add_real_time_options(CLI::App& command, RealTimeArguments& arguments);

/// What the run's threads are to enter; nothing where it is off, or was not asked for and the source is not
/// live cameras. Throws UsageError, and Error where it is required and not permitted.
std::optional<RealTime> make_real_time(const RealTimeArguments& arguments, const RunArguments& run);

}  // namespace glint::apps
