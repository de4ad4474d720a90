// SPDX-License-Identifier: MIT
// What it ran on, the headline, the figures, the stages.
#include "host/bench/report_markdown.hpp"

#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <initializer_list>

namespace glint::bench {
namespace {

constexpr double kLoadWorthSaying = 0.1;  // cores

std::string formatted(const char* format, double value) {
  char text[48];
  std::snprintf(text, sizeof text, format, value);
  return text;
}

std::string ms(double seconds) { return formatted("%.3f", 1e3 * seconds); }

/// A | in a name would end its cell.
std::string cell(const std::string& text) {
  std::string safe;
  for (const char c : text) {
    if (c == '|') safe += '\\';
    safe += c == '\n' ? ' ' : c;
  }
  return safe;
}

/// A table whose columns are wide enough to be read as plain text, too.
class Table {
 public:
  explicit Table(std::vector<std::string> head) { add(std::move(head)); }

  void add(std::vector<std::string> row) {
    for (std::string& text : row) text = cell(text);
    rows_.push_back(std::move(row));
  }

  std::string text() const {
    std::string out;
    for (std::size_t r = 0; r < rows_.size(); ++r) {
      for (std::size_t c = 0; c < rows_.front().size(); ++c) {
        const std::string& text = c < rows_[r].size() ? rows_[r][c] : "";
        const std::string padding(width(c) - letters(text), ' ');
        out += "| " + (numeric(c) ? padding + text : text + padding) + " ";
      }
      out += "|\n";
      if (r > 0) continue;
      for (std::size_t c = 0; c < rows_.front().size(); ++c)
        out += "|" + std::string(width(c) + 1, '-') + (numeric(c) ? ":" : "-");
      out += "|\n";
    }
    return out;
  }

 private:
  static std::size_t letters(const std::string& text) {  // of UTF-8
    std::size_t n = 0;
    for (const char c : text) n += (static_cast<unsigned char>(c) & 0xc0u) != 0x80u ? 1 : 0;
    return n;
  }
  std::size_t width(std::size_t column) const {
    std::size_t widest = 1;
    for (const auto& row : rows_) {
      if (column < row.size()) widest = std::max(widest, letters(row[column]));
    }
    return widest;
  }
  /// All that is filled below the head begins with a digit.
  bool numeric(std::size_t column) const {
    bool any = false;
    for (std::size_t r = 1; r < rows_.size(); ++r) {
      if (column >= rows_[r].size() || rows_[r][column].empty()) continue;
      if (rows_[r][column][0] < '0' || rows_[r][column][0] > '9') return false;
      any = true;
    }
    return any && column > 1;
  }

  std::vector<std::vector<std::string>> rows_;
};

std::string device_line(const DeviceResult& device) {
  std::string text = display_name(device);
  if (!device.vulkan) return text + ": the native detector, without Vulkan";
  text += ": " + device.vulkan->device_type + ", Vulkan " + device.vulkan->api_version;
  if (!device.vulkan->driver_name.empty())
    text += ", driver " + device.vulkan->driver_name + " " + device.vulkan->driver_info;
  return text;
}

std::string conditions_text(const Conditions& c) {
  return "up to " + std::to_string(c.ticks) + " ticks or " + formatted("%g", c.max_time_s) + " s after " +
         std::to_string(c.warm_up) + " to warm up; " + std::to_string(c.depth) +
         " in flight for ticks/s; paced at " + formatted("%g", c.rate_hz) + " Hz";
}

std::string build_text(const Results& r) {
  return r.glint_version + " (" + r.glint_commit + "), shaders " + r.shader_hash;
}

/// The most that other programs had of the cores during one row.
double other_load_cores(const Results& results) {
  double most = 0.0;
  for (const DeviceResult& device : results.devices) {
    for (const Row& row : device.rows) most = std::max(most, row.other_load_cores.value_or(0.0));
  }
  return most;
}

std::string about(const Results& results, const Baseline* baseline) {
  const Machine& m = results.machine;
  Table table({"glint bench", results.started_utc});
  table.add({"glint", build_text(results)});
  table.add({"processor", m.processor + ", " + std::to_string(m.logical_cores) + " logical cores" +
                              (m.governor.empty() ? "" : ", governor " + m.governor)});
  table.add({"system", m.system + ", " + m.kernel + ", " + m.architecture});
  for (const DeviceResult& device : results.devices) table.add({"device", device_line(device)});
  table.add({"run", conditions_text(results.conditions)});
  if (baseline != nullptr)
    table.add({"compared with", std::filesystem::path(baseline->path).filename().string() + ": glint " +
                                    build_text(baseline->results)});
  if (const double load = other_load_cores(results); load >= kLoadWorthSaying) {
    table.add({"note", "other programs kept up to " + formatted("%.1f", load) + " of " +
                           std::to_string(m.logical_cores) +
                           " cores busy: expect slower and noisier figures"});
  }
  for (const std::string& note : results.notes) table.add({"note", note});
  return table.text();
}

/// Why there are no figures stands below the tables, or it would make them too wide to read.
std::string verdict_cell(Outcome outcome) {
  return outcome == Outcome::Ok ? "yes" : outcome == Outcome::Wrong ? "**FAIL**" : "no result";
}

std::string headline_cell(const Headline& headline) {
  if (headline.outcome != Outcome::Ok) return verdict_cell(headline.outcome);
  if (headline.cameras == 0) return "not even 1";
  return std::to_string(headline.cameras) + (headline.at_limit          ? " or more"
                                             : headline.problem.empty() ? ""
                                                                        : " (more cannot be set up)");
}

std::string headlines(const Results& results) {
  const SceneKey& scene = results.headline_scene;
  Table table({"device", "rate", "most cameras", "p99 ms", "frame time ms"});
  bool any = false;
  for (const DeviceResult& device : results.devices) {
    for (const Headline& headline : device.headlines) {
      const bool figures = headline.outcome == Outcome::Ok && headline.cameras > 0;
      table.add({display_name(device), formatted("%g Hz", headline.rate_hz), headline_cell(headline),
                 figures ? ms(headline.p99_s) : "",
                 headline.outcome == Outcome::Ok ? formatted("%.1f", 1e3 / headline.rate_hz) : ""});
      any = true;
    }
  }
  if (!any) return "";
  return "\nMost cameras of " + std::to_string(scene.width_px) + "x" + std::to_string(scene.height_px) +
         " with " + std::to_string(scene.blobs) +
         " blobs each that a device keeps up with (paced, p99 from submit to result under the frame "
         "time):\n\n" +
         table.text();
}

void add_change(std::vector<std::string>& cells, const std::optional<Change>& change) {
  if (!change) {
    cells.insert(cells.end(), {"", "", "nothing to compare with"});
    return;
  }
  cells.insert(cells.end(), {ms(change->old_p50), formatted("%.2f", change->ratio), text(change->verdict)});
}

std::string figures(const Results& results, const Baseline* baseline) {
  std::vector<std::string> head{"device", "scene",  "correct", "p50 ms",       "p90",   "p99",
                                "max",    "CPU ms", "ticks/s", "paced p99 ms", "missed"};
  if (baseline != nullptr) head.insert(head.end(), {"old p50 ms", "new/old", "verdict"});
  Table table(head);
  for (const DeviceResult& device : results.devices) {
    for (const Row& row : device.rows) {
      std::vector<std::string> cells{display_name(device), display_name(row.scene)};
      cells.push_back(verdict_cell(row.outcome));
      if (row.outcome != Outcome::Ok) {
        table.add(cells);
        continue;
      }
      const Summary& wall = row.wall.summary;
      const Summary& paced = row.paced.latency.summary;
      cells.insert(cells.end(), {ms(wall.p50), ms(wall.p90), ms(wall.p99), ms(wall.max),
                                 ms(row.cpu.summary.p50), formatted("%.0f", row.ticks_per_s), ms(paced.p99),
                                 std::to_string(row.paced.missed) + " of " + std::to_string(paced.count)});
      if (baseline != nullptr) {
        add_change(cells,
                   change_of("wall", row.wall, matching_row(baseline->results, device.name, row.scene)));
      }
      table.add(cells);
    }
  }
  return std::string(
             "\nPer tick, one at a time, from submit to result; CPU: time of the whole process (median)") +
         (baseline != nullptr ? "; new/old under 1 is faster" : "") + ":\n\n" + table.text();
}

std::string problem_list(const Results& results) {
  std::string text;
  for (const std::string& problem : problems(results)) text += "* " + problem + "\n";
  return text.empty() ? "" : "\n" + text;
}

std::string stages(const Results& results) {
  Table table({"device", "scene", "stage", "p50 ms", "p90", "p99", "max"});
  bool any = false;
  for (const DeviceResult& device : results.devices) {
    for (const Row& row : device.rows) {
      for (const StageSeries& stage : row.stages) {
        const Summary& s = stage.time.summary;
        table.add({display_name(device), display_name(row.scene), stage.name, ms(s.p50), ms(s.p90), ms(s.p99),
                   ms(s.max)});
        any = true;
      }
    }
  }
  if (!any) return "";
  return "\nStages of these ticks (Vulkan: time stamps of the device; cpu: wall time):\n\n" + table.text();
}

}  // namespace

std::string to_markdown(const Results& results, const Baseline* baseline) {
  return about(results, baseline) + headlines(results) + figures(results, baseline) + problem_list(results) +
         stages(results);
}

}  // namespace glint::bench
