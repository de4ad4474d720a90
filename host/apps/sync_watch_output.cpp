// SPDX-License-Identifier: MIT
// The two ways of printing.
#include "host/apps/sync_watch_output.hpp"

#include <sys/ioctl.h>
#include <unistd.h>

#include <nlohmann/json.hpp>

#include "host/apps/sync_json.hpp"
#include "host/apps/sync_text.hpp"
#include "host/base/error.hpp"
#include "usb-sync/board_text.hpp"

namespace glint::apps {
namespace {

using Json = nlohmann::ordered_json;
using ull = unsigned long long;

constexpr const char* kClearLine = "\r\x1b[K";

std::string delay_text(const DelayFigures& delay) {
  return format_text("%.2f/%.2f/%.2f ms", delay.p50_s * 1e3, delay.p99_s * 1e3, delay.max_s * 1e3);
}

Json delay_json(const DelayFigures& delay) {
  return {{"count", delay.count}, {"p50_s", delay.p50_s}, {"p99_s", delay.p99_s}, {"max_s", delay.max_s}};
}

Json counters_json(const sync::LinkCounters& counters) {
  return {{"received", counters.reports}, {"fetched", counters.fetched}, {"lost", counters.lost},
          {"flawed", counters.flawed},    {"stale", counters.stale},     {"gone", counters.gone},
          {"resets", counters.resets}};
}

void write(std::FILE* file, const std::string& text) {
  if (std::fwrite(text.data(), 1, text.size(), file) != text.size() || std::fflush(file) != 0)
    throw Error("the output cannot be written any more");
}

class TextSink final : public WatchSink {
 public:
  explicit TextSink(std::FILE* file) : file_(file), terminal_(isatty(fileno(file)) == 1) {}

  void begin(const sync::Info& info) override {
    write(file_,
          board_line(info) +
              "delay: of reports, p50/p99/max; clock: how far host times of the board's ticks may be off\n");
  }

  void event(const WatchEvent& event) override {
    write(file_, (terminal_ ? kClearLine : "") + format_text("%9.3f s  ", event.since_start_s) + event.text +
                     "\n" + line_);
  }

  void update(const WatchUpdate& update) override {
    const std::string line = watch_line(update);
    if (!terminal_) {
      write(file_, line + "\n");
      return;
    }
    line_ = line.substr(0, columns() - 1);  // a line that wraps cannot be rewritten
    write(file_, kClearLine + line_);
  }

  void end(const WatchSummary& summary) override {
    write(file_, (line_.empty() ? "" : "\n") + summary_text(summary));
  }

 private:
  std::size_t columns() const {
    winsize size{};
    const bool known = ioctl(fileno(file_), TIOCGWINSZ, &size) == 0 && size.ws_col > 1;
    return known ? size.ws_col : 80;
  }

  std::FILE* file_;
  bool terminal_;
  std::string line_;  // as it stands on the terminal; "" elsewhere
};

class JsonSink final : public WatchSink {
 public:
  explicit JsonSink(std::FILE* file) : file_(file) {}

  void begin(const sync::Info& info) override {
    Json json{{"type", "board"}};
    json.update(info_json(info));
    put(json);
  }

  void event(const WatchEvent& event) override {
    Json json{{"type", "event"},
              {"since_start_s", event.since_start_s},
              {"event", event.kind},
              {"text", event.text}};
    if (event.run) json["run"] = *event.run;
    if (event.frame) json["frame"] = *event.frame;
    if (event.when) {
      json["time_ns"] =
          std::chrono::duration_cast<std::chrono::nanoseconds>(event.when->time.time_since_epoch()).count();
      json["time_error_s"] = event.when->half_width.count();
    }
    put(json);
  }

  void update(const WatchUpdate& update) override {
    Json json{{"type", "update"},
              {"since_start_s", update.since_start_s},
              {"present", update.present},
              {"trouble", update.trouble},
              {"state", state_key(update.state)},
              {"run", update.run},
              {"rate_hz", nullptr},
              {"frames", update.window.frames},
              {"report_delay", delay_json(update.window.delay)},
              {"supply_v", update.supply_v},
              {"supply_locked", update.supply_locked},
              {"fault", update.fault},
              {"clock_error_s", nullptr},
              {"reports", counters_json(update.counters)}};
    if (update.window.rate_hz) json["rate_hz"] = *update.window.rate_hz;
    if (update.clock_bound_s) json["clock_error_s"] = *update.clock_bound_s;
    put(json);
  }

  void end(const WatchSummary& s) override {
    put({{"type", "summary"},
         {"seconds", s.seconds},
         {"frames", s.frames.seen},
         {"missing", s.frames.missing},
         {"dark", s.frames.dark},
         {"locked", s.frames.locked},
         {"held", s.frames.held},
         {"report_delay", delay_json(s.delay)},
         {"reports", counters_json(s.counters)},
         {"least_supply_v", s.least_supply_v},
         {"most_supply_v", s.most_supply_v},
         {"clock_restarts", s.clock_restarts}});
  }

 private:
  void put(const Json& json) {
    write(file_, json.dump(-1, ' ', false, Json::error_handler_t::replace) + "\n");
  }

  std::FILE* file_;
};

}  // namespace

std::string watch_line(const WatchUpdate& u) {
  std::string text = format_text("%9.1f s  ", u.since_start_s);
  if (!u.present) return text + "no board" + (u.trouble.empty() ? "" : ": " + u.trouble);
  text += sync::state_text(u.state);
  if (u.fault != 0) text += "  FAULT: " + sync::fault_text(u.fault);
  if (u.supply_locked) text += "  STROBES LOCKED OUT";
  if (u.window.rate_hz) text += format_text("  %.3f Hz", *u.window.rate_hz);
  if (u.window.delay.count > 0) text += "  delay " + delay_text(u.window.delay);
  text += format_text("  %.2f V  %llu lost, %llu fetched", u.supply_v, ull{u.counters.lost},
                      ull{u.counters.fetched});
  if (u.clock_bound_s) text += format_text("  clock +-%.0f us", *u.clock_bound_s * 1e6);
  return text;
}

std::string summary_text(const WatchSummary& s) {
  const sync::LinkCounters& c = s.counters;
  std::string text = format_text("watched for %.1f s\n", s.seconds);
  text += format_text(
      "  frames   %llu, and %llu missing; %llu dark by the code, %llu without light for the supply\n",
      ull{s.frames.seen}, ull{s.frames.missing}, ull{s.frames.dark}, ull{s.frames.locked});
  if (s.frames.held > 0) {
    text += format_text("  held     %llu frames lack a strobe that came too soon: please report this\n",
                        ull{s.frames.held});
  }
  text += format_text("  reports  %llu received, %llu fetched, %llu lost, %llu flawed\n", ull{c.reports},
                      ull{c.fetched}, ull{c.lost}, ull{c.flawed});
  if (s.delay.count > 0) text += "  delay    " + delay_text(s.delay) + " (p50 / p99 / max)\n";
  text += format_text("  supply   %.2f to %.2f V\n", s.least_supply_v, s.most_supply_v);
  text += format_text("  board    gone %s, reset %s\n", count_text(c.gone, "time").c_str(),
                      count_text(c.resets, "time").c_str());
  if (s.clock_restarts > 0)
    text += format_text("  clocks   matched anew %s\n", count_text(s.clock_restarts, "time").c_str());
  return text;
}

std::unique_ptr<WatchSink> make_text_sink(std::FILE* file) { return std::make_unique<TextSink>(file); }

std::unique_ptr<WatchSink> make_json_sink(std::FILE* file) { return std::make_unique<JsonSink>(file); }

}  // namespace glint::apps
