// SPDX-License-Identifier: MIT
// Numbers to words.
#include "host/apps/run_summary.hpp"

#include <algorithm>
#include <array>
#include <cstdarg>
#include <cstdio>

#include <nlohmann/json.hpp>

#include "host/apps/alignment_text.hpp"
#include "host/apps/health_text.hpp"

namespace glint::apps {
namespace {

__attribute__((format(printf, 1, 2))) std::string text(const char* format, ...) {
  char buffer[256];
  va_list arguments;
  va_start(arguments, format);
  std::vsnprintf(buffer, sizeof buffer, format, arguments);
  va_end(arguments);
  return buffer;
}

unsigned long long number_of(std::uint64_t value) { return value; }

std::string latency(const LatencyHistogram& h) {
  return text("%.2f / %.2f / %.2f ms", h.quantile_s(0.5) * 1e3, h.quantile_s(0.99) * 1e3, h.max_s() * 1e3);
}

std::string millimetres(double metres) { return text("%.4f mm", metres * 1e3); }

std::string percent(double share) { return text("%.3f %%", share * 100.0); }

nlohmann::ordered_json latency_json(const LatencyHistogram& h) {
  return {{"p50_s", h.quantile_s(0.5)},
          {"p99_s", h.quantile_s(0.99)},
          {"max_s", h.max_s()},
          {"count", h.count()}};
}

constexpr std::array<const char*, kFrameFates> kFateNames{
    "used", "late", "skipped", "lost by host", "lost by camera", "corrupt", "dark"};
constexpr std::array<const char*, kFrameFates> kFateKeys{
    "used", "late", "skipped", "lost_by_host", "lost_by_camera", "corrupt", "dark"};

const char* stamp_key(StampPoint stamp) {
  switch (stamp) {
    case StampPoint::StartOfExposure:
      return "start_of_exposure";
    case StampPoint::MiddleOfExposure:
      return "middle_of_exposure";
    case StampPoint::EndOfFrame:
      return "end_of_frame";
    case StampPoint::HostArrival:
      break;
  }
  return "host_arrival";
}

/// What the driver's stamp leaves out or holds.
const char* stamp_note(StampPoint stamp) {
  switch (stamp) {
    case StampPoint::StartOfExposure:
      return "p50 / p99 / max; stamps mark the start of the exposure or of the transfer, which is in it";
    case StampPoint::MiddleOfExposure:
      return "p50 / p99 / max; stamps mark the middle of the exposure";
    case StampPoint::EndOfFrame:
      return "p50 / p99 / max; stamps mark the end of the transfer";
    case StampPoint::HostArrival:
      break;
  }
  return "p50 / p99 / max; no stamp of the driver was usable: from arrival";
}

nlohmann::ordered_json real_time_json(const RealTimeState& state) {
  nlohmann::ordered_json threads = nlohmann::ordered_json::array();
  for (std::size_t n = 0; n < kThreadRoles; ++n) {
    const ThreadRole role{static_cast<std::uint8_t>(n)};
    threads.push_back({{"name", name_of(role)},
                       {"started", state.threads[n]},
                       {"priority", fifo_priority(role)},
                       {"fifo", state.fifo[n]},
                       {"pinned", state.pinned[n]}});
  }
  return {{"mode", name_of(state.mode)},
          {"threads", std::move(threads)},
          {"memory_locked", state.memory_locked},
          {"cpus", state.cpus},
          {"refusal", state.refusal}};
}

/// "1000 pulses: 990 used, 10 late"
std::string ledger_text(const CameraLedger& camera, std::uint64_t pulses) {
  std::string line;
  const auto append = [&line](std::uint64_t count, const char* what) {
    if (count > 0) line += text("%s%llu %s", line.empty() ? "" : ", ", number_of(count), what);
  };
  for (std::size_t n = 0; n < kFrameFates; ++n) append(camera.count[n], kFateNames[n]);
  return text("%llu pulses: ", number_of(pulses)) + (line.empty() ? "nothing" : line);
}

std::string refused_text(const CameraLedger& camera) {
  if (camera.duplicates + camera.unplaced == 0) return "";
  return text("and %llu duplicates, %llu frames that fit no pulse", number_of(camera.duplicates),
              number_of(camera.unplaced));
}

nlohmann::ordered_json ledger_json(const RunSummary& s) {
  nlohmann::ordered_json cameras = nlohmann::ordered_json::array();
  for (std::size_t i = 0; i < s.ledger->cameras.size(); ++i) {
    const CameraLedger& camera = s.ledger->cameras[i];
    nlohmann::ordered_json one{{"name", s.cameras.at(i)}};
    for (std::size_t n = 0; n < kFrameFates; ++n) one[kFateKeys[n]] = camera.count[n];
    one["duplicates"] = camera.duplicates;
    one["unplaced"] = camera.unplaced;
    cameras.push_back(std::move(one));
  }
  return {{"pulses", s.ledger->pulses}, {"cameras", std::move(cameras)}};
}

}  // namespace

std::vector<ReportRow> summary_rows(const RunSummary& s) {
  std::vector<ReportRow> rows;
  const auto add = [&rows](std::string name, std::string value, std::string note = {},
                           bool headline = false) {
    rows.push_back({std::move(name), std::move(value), std::move(note), headline});
  };
  const double ticks = static_cast<double>(std::max<std::uint64_t>(1, s.counters.ticks));
  add("rate", text("%.1f Hz", s.rate_hz),
      s.nominal_rate_hz > 0.0 ? text("nominal %.1f Hz", s.nominal_rate_hz) : "", true);
  add("missed ticks",
      text("%llu of %llu", number_of(s.missed()), number_of(s.counters.ticks + s.input.dropped)),
      text("dropped %llu, late %llu, not written %llu", number_of(s.input.dropped), number_of(s.input.late),
           number_of(s.counters.results_dropped)),
      true);
  if (s.end_to_end.count() > 0) {
    add("end to end", latency(s.end_to_end), "p50 / p99 / max, last byte in to points out", true);
    add("detection", latency(s.detection), "p50 / p99 / max");
  }
  if (s.stamp_to_output.count() > 0) {
    add("driver's stamp to output", latency(s.stamp_to_output), stamp_note(s.stamp), true);
    add("time of exposure known to", latency(s.time_error), "p50 / p99 / max, bound of the error");
  }
  if (s.score) {
    const ScoreResult& r = *s.score;
    add("RMS error", millimetres(r.rms_m),
        text("median %.4f mm, worst %.3f mm", r.median_m * 1e3, r.max_m * 1e3), true);
    add("recall", percent(r.recall),
        text("%llu of %llu markers seen alone by two or more cameras", number_of(r.found),
             number_of(r.expected)));
    add("recall, merged blobs included", percent(r.recall_visible),
        text("%llu of %llu", number_of(r.found_visible), number_of(r.expected_visible)));
    add("ghosts",
        text("%llu of %llu points (%.4f %%)", number_of(r.ghosts), number_of(r.points), r.ghost_rate * 100.0),
        r.doubled > 0 ? text("and %llu second points of one marker", number_of(r.doubled)) : "");
    add("RMS over Cramer-Rao bound", text("%.2f", r.ratio),
        text("bound %.4f mm, RMS where each blob stood alone %.4f mm", r.bound_rms_m * 1e3,
             r.rms_clean_m * 1e3));
    add("identity switches", text("%llu", number_of(r.id_switches)));
  }
  add("points", text("%llu", number_of(s.counters.points)),
      text("%.2f a tick, %llu identities", static_cast<double>(s.counters.points) / ticks, number_of(s.ids)));
  for (ReportRow& row : identity_rows(s.kinds, s.counters.track, s.counters.match))
    rows.push_back(std::move(row));
  for (ReportRow& row : body_rows(s.bodies, s.counters.body)) rows.push_back(std::move(row));
  if (s.plane_height_m)
    add("plane of the markers", text("z = %g m", *s.plane_height_m),
        "one camera: x and y are measured, z is given");
  add("blobs", text("%.1f a tick", static_cast<double>(s.counters.match.blobs) / ticks),
      text("unmatched %.2f a tick", static_cast<double>(s.counters.match.unmatched_blobs) / ticks));
  if (s.input.overflows > 0)
    add("overflowed images", text("%llu", number_of(s.input.overflows)),
        "more blobs than room: some are missing");
  if (s.counters.match.hypotheses_cut > 0) {
    add("correspondence cut", text("%llu hypotheses", number_of(s.counters.match.hypotheses_cut)),
        "a limit was reached");
  }
  if (s.counters.match.inexact > 0) {
    add("correspondence groups not solved exactly", text("%llu", number_of(s.counters.match.inexact)));
  }
  for (std::size_t i = 0; s.ledger && i < s.ledger->cameras.size(); ++i) {
    const CameraLedger& camera = s.ledger->cameras[i];
    add("camera " + s.cameras.at(i), ledger_text(camera, s.ledger->pulses), refused_text(camera));
  }
  for (ReportRow& row : health_rows(s.health, s.cameras)) rows.push_back(std::move(row));
  if (s.code) {
    for (ReportRow& row : alignment_rows(*s.code, s.cameras)) rows.push_back(std::move(row));
  }
  if (s.board) {
    const BoardCounters& b = *s.board;
    add("sync board " + s.board_serial,
        text("%llu pulses, %llu not told of, times known to %.1f us", number_of(b.pulses),
             number_of(b.not_told + b.not_taken), b.worst_error_s * 1e6),
        b.gone + b.resets + b.lockouts == 0
            ? ""
            : text("gone %llu times, reset %llu, lights held off %llu", number_of(b.gone),
                   number_of(b.resets), number_of(b.lockouts)));
  }
  const SourceCounters& f = s.input.source;
  if (!s.ledger && f.missing + f.damaged + f.late + f.duplicated + f.no_slot > 0) {
    add("frames lost by the source",
        text("%llu missing, %llu damaged, %llu late, %llu duplicated, %llu without memory",
             number_of(f.missing), number_of(f.damaged), number_of(f.late), number_of(f.duplicated),
             number_of(f.no_slot)));
  }
  add("ticks", text("%llu in %.2f s", number_of(s.counters.ticks), s.wall_s));
  add("source", s.source);
  add("rig", s.rig);
  add("device", s.device);
  if (s.real_time) add("real time", text_of(*s.real_time), s.real_time->refusal);
  return rows;
}

std::string summary_text(const RunSummary& summary) {
  std::string all;
  for (const ReportRow& row : summary_rows(summary)) {
    all += text("%-29s ", row.name.c_str()) + row.value + (row.note.empty() ? "" : "   (" + row.note + ")") +
           "\n";
  }
  return all;
}

std::string summary_json(const RunSummary& s) {
  nlohmann::ordered_json j{{"source", s.source},
                           {"rig", s.rig},
                           {"device", s.device},
                           {"ticks", s.counters.ticks},
                           {"wall_s", s.wall_s},
                           {"rate_hz", s.rate_hz},
                           {"missed", s.missed()},
                           {"dropped", s.input.dropped},
                           {"late", s.input.late},
                           {"results_dropped", s.counters.results_dropped},
                           {"points", s.counters.points},
                           {"ids", s.ids},
                           {"identity", identity_json(s.kinds, s.counters.track, s.counters.match)},
                           {"blobs", s.counters.match.blobs},
                           {"unmatched_blobs", s.counters.match.unmatched_blobs},
                           {"overflows", s.input.overflows},
                           {"hypotheses_cut", s.counters.match.hypotheses_cut},
                           {"inexact", s.counters.match.inexact},
                           {"detection", latency_json(s.detection)},
                           {"end_to_end", latency_json(s.end_to_end)}};
  const SourceCounters& f = s.input.source;
  j["frames"] = {{"delivered", f.frames}, {"missing", f.missing},       {"damaged", f.damaged},
                 {"late", f.late},        {"duplicated", f.duplicated}, {"no_slot", f.no_slot}};
  if (s.stamp_to_output.count() > 0) {
    j["stamp_to_output"] = latency_json(s.stamp_to_output);
    j["stamp_to_output"]["stamp"] = stamp_key(s.stamp);
    j["time_error"] = latency_json(s.time_error);
  }
  if (s.real_time) j["real_time"] = real_time_json(*s.real_time);
  if (s.ledger) j["ledger"] = ledger_json(s);
  if (!s.bodies.bodies.empty()) j["bodies"] = body_json(s.bodies, s.counters.body);
  if (s.plane_height_m) j["plane_height_m"] = *s.plane_height_m;
  j["health"] = health_json(s.health, s.cameras);
  if (s.code) j["alignment"] = alignment_json(*s.code, s.cameras);
  if (s.board) {
    const BoardCounters& b = *s.board;
    j["sync_board"] = {{"serial", s.board_serial}, {"pulses", b.pulses},
                       {"not_told", b.not_told},   {"not_taken", b.not_taken},
                       {"gone", b.gone},           {"resets", b.resets},
                       {"lockouts", b.lockouts},   {"worst_error_s", b.worst_error_s}};
  }
  if (s.score) {
    const ScoreResult& r = *s.score;
    j["score"] = {{"recall", r.recall},
                  {"recall_visible", r.recall_visible},
                  {"expected", r.expected},
                  {"ghosts", r.ghosts},
                  {"ghost_rate", r.ghost_rate},
                  {"doubled", r.doubled},
                  {"rms_m", r.rms_m},
                  {"rms_clean_m", r.rms_clean_m},
                  {"median_m", r.median_m},
                  {"max_m", r.max_m},
                  {"bound_rms_m", r.bound_rms_m},
                  {"ratio", r.ratio},
                  {"median_ratio", r.median_ratio},
                  {"id_switches", r.id_switches}};
  }
  return j.dump(2) + "\n";
}

}  // namespace glint::apps
