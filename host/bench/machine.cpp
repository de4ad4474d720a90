// SPDX-License-Identifier: MIT
// Reads what Linux tells about the computer.
#include "host/bench/machine.hpp"

#include <sys/utsname.h>
#include <unistd.h>

#include <algorithm>
#include <ctime>
#include <fstream>
#include <thread>

namespace glint::bench {
namespace {

/// What follows `key` and `separator` on the first line that starts with the key; "" if there is none.
std::string value_of(const char* file, const std::string& key, char separator) {
  std::ifstream lines(file);
  for (std::string line; std::getline(lines, line);) {
    if (!line.starts_with(key)) continue;
    const std::size_t at = line.find(separator);
    if (at == std::string::npos) continue;
    std::string value = line.substr(at + 1);
    const auto idle = [](char c) { return c == ' ' || c == '\t' || c == '"'; };
    value.erase(value.begin(), std::find_if_not(value.begin(), value.end(), idle));
    value.erase(std::find_if_not(value.rbegin(), value.rend(), idle).base(), value.end());
    return value;
  }
  return "";
}

std::string first_line(const char* file) {
  std::ifstream lines(file);
  std::string line;
  std::getline(lines, line);
  return line;
}

std::string processor() {
  std::string name = value_of("/proc/cpuinfo", "model name", ':');
  // ARM boards name the board instead; that file ends with a zero byte.
  if (name.empty()) name = first_line("/sys/firmware/devicetree/base/model").c_str();
  return name;
}

}  // namespace

Machine describe_machine() {
  Machine machine;
  machine.processor = processor();
  machine.logical_cores = std::thread::hardware_concurrency();
  machine.system = value_of("/etc/os-release", "PRETTY_NAME", '=');
  machine.governor = first_line("/sys/devices/system/cpu/cpu0/cpufreq/scaling_governor");
  if (utsname names{}; uname(&names) == 0) {
    machine.kernel = std::string(names.sysname) + " " + names.release;
    machine.architecture = names.machine;
  }
#if defined(__clang__)
  machine.compiler = "Clang " __clang_version__;
#elif defined(__GNUC__)
  machine.compiler = "GCC " __VERSION__;
#endif
  return machine;
}

std::optional<double> busy_core_s() {
  std::ifstream file("/proc/stat");
  std::string word;
  double user = 0.0, nice = 0.0, system = 0.0, idle = 0.0, waiting = 0.0, irq = 0.0, soft_irq = 0.0,
         stolen = 0.0;
  file >> word >> user >> nice >> system >> idle >> waiting >> irq >> soft_irq >> stolen;
  if (!file || word != "cpu") return std::nullopt;
  // Stolen: the core was wanted, and another virtual machine had it.
  return (user + nice + system + irq + soft_irq + stolen) / static_cast<double>(sysconf(_SC_CLK_TCK));
}

std::string utc_now() {
  const std::time_t now = std::time(nullptr);
  std::tm parts{};
  gmtime_r(&now, &parts);
  char text[32];
  std::strftime(text, sizeof text, "%Y-%m-%dT%H:%M:%SZ", &parts);
  return text;
}

}  // namespace glint::bench
