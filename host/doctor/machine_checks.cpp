// SPDX-License-Identifier: MIT
// Reads /sys and asks the kernel for permission.
#include "host/doctor/machine_checks.hpp"

#include <unistd.h>

#include <algorithm>
#include <map>
#include <optional>
#include <string_view>
#include <system_error>

#include "host/doctor/system_files.hpp"
#include "host/realtime/cpu_list.hpp"
#include "host/realtime/real_time.hpp"

namespace glint {
namespace {

namespace fs = std::filesystem;

std::string device_text(const gpu::DeviceInfo& device) {
  return device.name + (device.imports_host_memory ? ", reads frames in place" : ", frames are copied to it");
}

}  // namespace

Finding check_vulkan(const std::vector<gpu::DeviceInfo>& devices, const std::string& problem) {
  constexpr std::string_view kCpu =
      "the processor detects instead (--device cpu), which glint does not choose by "
      "itself; ";
  const auto usable = [&](bool software) -> const gpu::DeviceInfo* {
    const auto found = std::find_if(devices.begin(), devices.end(), [&](const gpu::DeviceInfo& device) {
      return device.usable && device.software == software;
    });
    return found == devices.end() ? nullptr : &*found;
  };
  std::string refused;
  for (const gpu::DeviceInfo& device : devices) {
    if (!device.usable) refused += (refused.empty() ? "" : "; ") + device.name + ": " + device.why_not_usable;
  }
  if (const gpu::DeviceInfo* const gpu = usable(false))
    return {"vulkan", Verdict::Ok, device_text(*gpu), refused};
  if (const gpu::DeviceInfo* const software = usable(true)) {
    return {
        "vulkan", Verdict::Warning, "no GPU, only software: " + device_text(*software),
        (refused.empty() ? "" : refused + "; ") +
            std::string("install the GPU's Vulkan driver (mesa-vulkan-drivers for Intel and AMD), or compare "
                        "with --device cpu: glint bench")};
  }
  return {"vulkan", Verdict::Warning, "no Vulkan device: " + (refused.empty() ? problem : refused),
          std::string(kCpu) + "install a Vulkan driver: mesa-vulkan-drivers"};
}

Findings check_hid(const fs::path& dev) {
  std::size_t all = 0, open = 0;
  std::error_code error;
  for (fs::directory_iterator it(dev, error), end; !error && it != end; it.increment(error)) {
    if (!it->path().filename().string().starts_with("hidraw")) continue;
    ++all;
    if (access(it->path().c_str(), R_OK | W_OK) == 0) ++open;
  }
  if (all == 0) return {};
  return {
      {"hidraw", Verdict::Ok,
       std::to_string(open) + " of " + std::to_string(all) +
           " HID nodes can be opened (only a sync board "
           "needs one)",
       open > 0 ? "" : "a udev rule with TAG+=\"uaccess\" or GROUP=\"plugdev\" for the board permits it"}};
}

Findings check_limits(SchedulerCalls& calls) {
  const RealTimePermission permission = real_time_permission(calls);
  Findings findings;
  const auto add = [&](const char* check, const char* good, const std::string& refusal) {
    findings.push_back(refusal.empty()
                           ? Finding{check, Verdict::Ok, good, ""}
                           : Finding{check, Verdict::Warning, refusal, std::string(kLimitsAdvice)});
  };
  add("priority", "SCHED_FIFO is permitted", permission.fifo_refusal);
  add("memory lock", "all memory may be locked", permission.lock_refusal);
  return findings;
}

Findings check_processors(const fs::path& sys, SchedulerCalls& calls) {
  const fs::path folder = sys / "devices" / "system" / "cpu";
  const std::vector<unsigned> cpus = calls.usable_cpus();
  std::map<std::string, std::vector<unsigned>> governors;
  for (const unsigned cpu : cpus) {
    if (const auto governor =
            first_line(folder / ("cpu" + std::to_string(cpu)) / "cpufreq" / "scaling_governor"))
      governors[*governor].push_back(cpu);
  }
  Findings findings;
  std::string slow;
  for (const auto& [governor, those] : governors) {
    if (governor != "performance")
      slow += (slow.empty() ? "" : ", ") + governor + " on " + cpu_list_text(those);
  }
  if (governors.empty()) {
    findings.push_back({"governor", Verdict::Ok, "the system does not tell (usual in virtual machines)", ""});
  } else if (slow.empty()) {
    findings.push_back({"governor", Verdict::Ok, "performance on all CPUs", ""});
  } else {
    findings.push_back({"governor", Verdict::Warning, slow,
                        "clocks that rise only under load cost milliseconds: sudo cpupower frequency-set -g "
                        "performance"});
  }
  const std::string isolated = first_line(folder / "isolated").value_or("");
  findings.push_back(
      {"cpus", Verdict::Ok,
       cpu_list_text(cpus) + " can be used, isolated: " + (isolated.empty() ? "none" : isolated),
       isolated.empty() ? "" : "glint track --pin " + isolated + " uses the isolated ones"});
  return findings;
}

Findings check_clocks(const fs::path& sys) {
  Findings findings;
  const fs::path clock = sys / "devices" / "system" / "clocksource" / "clocksource0" / "current_clocksource";
  const std::string source = first_line(clock).value_or("");
  // These are read over a slow bus, a microsecond or more each time, instead of from the processor.
  const bool slow = source == "hpet" || source == "acpi_pm" || source == "jiffies";
  findings.push_back(
      {"clock", slow ? Verdict::Warning : Verdict::Ok,
       source.empty() ? "the system does not tell its clock source" : "clock source " + source,
       slow ? "dmesg | grep -i clocksource tells why tsc was given up; a firmware update often helps" : ""});
  const auto uvc = first_line(sys / "module" / "uvcvideo" / "parameters" / "clock");
  if (uvc && *uvc != "CLOCK_MONOTONIC") {
    findings.push_back({"stamps", Verdict::Warning,
                        "uvcvideo stamps frames with " + *uvc +
                            ", which cannot be compared with other times: "
                            "frames count from their arrival",
                        "echo CLOCK_MONOTONIC | sudo tee /sys/module/uvcvideo/parameters/clock, and take the "
                        "option out of /etc/modprobe.d"});
  }
  return findings;
}

}  // namespace glint
