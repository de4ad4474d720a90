// SPDX-License-Identifier: MIT
// The computer itself: what detects, limits of the user, processors, clock, drivers' settings.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "gpu/detector.hpp"
#include "host/doctor/finding.hpp"
#include "host/realtime/scheduler_calls.hpp"

namespace glint {

/// `problem`: why there is no device, of gpu::list_devices(). No Vulkan is no problem: the processor can do
/// it.
Finding check_vulkan(const std::vector<gpu::DeviceInfo>& devices, const std::string& problem);

/// Nodes through which a sync board speaks. That none can be opened is no problem: rigs work without a board.
Findings check_hid(const std::filesystem::path& dev);

/// SCHED_FIFO and locked memory.
Findings check_limits(SchedulerCalls& calls);

/// Frequency governor and isolated CPUs.
Findings check_processors(const std::filesystem::path& sys, SchedulerCalls& calls);

/// What the kernel takes the time from, and what cameras' drivers stamp with.
Findings check_clocks(const std::filesystem::path& sys);

}  // namespace glint
