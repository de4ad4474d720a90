// SPDX-License-Identifier: MIT
#include "host/config/read_sync.hpp"

#include <algorithm>

#include "host/base/pulse_code.hpp"
#include "host/config/number_text.hpp"

namespace glint {
namespace {

constexpr std::uint32_t kAnyCount = 0xffffffff;
constexpr std::uint32_t kOutputs = 8, kMostEvery = 255, kMostKeepalive_ms = 65'535;
constexpr double kMostDelay_us = 1e7;

void read_output(const toml::table& table, SyncSettings& sync, FileProblems& problems) {
  TomlSection section(table, "sync.output " + std::to_string(sync.outputs.size() + 1), problems);
  SyncOutput output;
  if (section.whole("output", output.output, 0, kOutputs - 1, Need::Required) &&
      std::any_of(sync.outputs.begin(), sync.outputs.end(),
                  [&](const SyncOutput& other) { return other.output == output.output; })) {
    section.problem("output", std::to_string(output.output) + " stands here twice");
  }
  section.flag("enabled", output.enabled, Need::Optional);
  section.flag("active_low", output.active_low, Need::Optional);
  const auto time = [&](const char* key, std::optional<double>& value) {
    double us = 0.0;
    if (!section.number(key, us, Need::Optional)) return;
    if (us < 0.0 || us > kMostDelay_us)
      section.problem(key, "must be 0 to " + short_text(kMostDelay_us) + " us");
    value = us;
  };
  time("delay_us", output.delay_us);
  time("width_us", output.width_us);
  section.whole("every_n", output.every_n, 1, kMostEvery, Need::Optional);
  section.whole("phase", output.phase, 0, kMostEvery, Need::Optional);
  if (output.phase >= output.every_n)
    section.problem("phase", "must be below every_n (" + std::to_string(output.every_n) + ")");
  section.finish();
  sync.outputs.push_back(output);
}

}  // namespace

void SyncSettings::check(std::vector<std::string>& problems) const {
  const auto require = [&](bool fine, const std::string& text) {
    if (!fine) problems.push_back("sync." + text);
  };
  require(!board.empty(), "board must be \"none\", \"auto\" or a board's serial number");
  const auto time = [&](const char* name, double us, double least) {
    require(us >= least && us <= kMostDelay_us, std::string(name) + " must be " + short_text(least) + " to " +
                                                    short_text(kMostDelay_us) + ", not " + short_text(us));
  };
  time("trigger_us", trigger_us, 1.0);
  time("trigger_delay_us", trigger_delay_us, 0.0);
  time("strobe_us", strobe_us, 1.0);
  time("strobe_delay_us", strobe_delay_us, 0.0);
  require(code_group == 0 || (code_group >= PulseCode::kLeastGroup && code_group <= PulseCode::kMostGroup),
          "code_group must be 0 (as recommended for the rate) or " + std::to_string(PulseCode::kLeastGroup) +
              " to " + std::to_string(PulseCode::kMostGroup) + ", not " + std::to_string(code_group));
}

void read_sync(TomlSection& section, SyncSettings& sync, FileProblems& problems) {
  section.text("board", sync.board, Need::Optional);
  section.flag("follow", sync.follow, Need::Optional);
  section.number("trigger_us", sync.trigger_us, Need::Optional);
  section.number("trigger_delay_us", sync.trigger_delay_us, Need::Optional);
  section.number("strobe_us", sync.strobe_us, Need::Optional);
  section.number("strobe_delay_us", sync.strobe_delay_us, Need::Optional);
  section.whole("keepalive_ms", sync.keepalive_ms, 0, kMostKeepalive_ms, Need::Optional);
  section.flag("sync_out", sync.sync_out, Need::Optional);
  section.whole("code_seed", sync.code_seed, 0, kAnyCount, Need::Optional);
  section.whole("code_group", sync.code_group, 0, kAnyCount, Need::Optional);
  const toml::array* outputs = section.tables("output", Need::Optional);
  if (!outputs) return;
  for (const toml::node& node : *outputs) read_output(*node.as_table(), sync, problems);
}

}  // namespace glint
