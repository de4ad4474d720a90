// SPDX-License-Identifier: MIT
// Bodies in words and figures.
#include "host/apps/body_text.hpp"

#include <algorithm>
#include <cstdio>
#include <numbers>

#include "host/config/bodies_file.hpp"

namespace glint::apps {
namespace {

// The simulated rig's markers are where its bodies say; somebody who measured them well would be off by this.
constexpr double kSimulatedSd_m = 1e-5;

const char* reason(BodyDoubt doubt) {
  switch (doubt) {
    case BodyDoubt::Crossing:
      return "they came too close";
    case BodyDoubt::FoundAgain:
      return "it was lost, and could be either";
    case BodyDoubt::Symmetric:
      return "it looks the same when turned";
    case BodyDoubt::None:
      break;
  }
  return "the odds are too close";
}

std::string number_of(std::uint64_t value) { return std::to_string(value); }

double share(std::uint64_t part, std::uint64_t whole) {
  return whole == 0 ? 0.0 : static_cast<double>(part) / static_cast<double>(whole);
}

std::string percent(double share) {
  char text[32];
  std::snprintf(text, sizeof text, "%.3f %%", 100.0 * share);
  return text;
}

double degrees(double radians) { return radians * 180.0 / std::numbers::pi; }

}  // namespace

std::vector<BodyModel> chosen_bodies(const Rig& rig, std::span<const std::filesystem::path> files,
                                     const Scene* scene) {
  std::vector<BodyModel> bodies = rig.bodies;
  for (const std::filesystem::path& file : files)
    for (BodyModel& body : read_bodies(file)) bodies.push_back(std::move(body));
  if (bodies.empty() && scene != nullptr) {
    for (std::uint32_t b = 0; b < scene->bodies(); ++b)
      bodies.push_back({"body" + number_of(b + 1), scene->body_markers(b), kSimulatedSd_m});
  }
  check_bodies(bodies);
  return bodies;
}

std::string event_text(TriggerNo tick, const BodyEvent& event, std::span<const BodyModel> bodies) {
  const std::string start = "tick " + number_of(number(tick)) + ": body " + bodies[event.body].name;
  const std::string& other = bodies[event.other].name;
  switch (event.kind) {
    case BodyEventKind::Found:
      return start + " found";
    case BodyEventKind::Lost:
      return start + " lost";
    case BodyEventKind::Kept:
      return start + (event.body == event.other ? " is turned as it was given out"
                                                : " is itself, and was all the time, not " + other);
    case BodyEventKind::Exchanged:
      return start + (event.body == event.other ? " was given out turned wrongly: right again"
                                                : " had changed names with " + other + ": right again");
    case BodyEventKind::Ambiguous:
      break;
  }
  return start + (event.body == event.other ? " may be turned otherwise: " : " may be " + other + ": ") +
         reason(event.doubt);
}

void to_scored(std::span<const TrackedBody> bodies, std::vector<ScoredPose>& poses) {
  poses.clear();
  for (const TrackedBody& body : bodies)
    poses.push_back({body.body, body.world_from_body, body.kind == BodyKind::Measured, body.ambiguous});
}

void BodyRun::add(std::span<const TrackedBody> rows) noexcept {
  ++exposures;
  for (BodySteadiness& body : steadiness)
    if (body.measured > 0) ++body.gap;
  for (const TrackedBody& row : rows) {
    BodySteadiness& body = steadiness[row.body];
    body.ambiguous += row.ambiguous ? 1u : 0u;
    if (row.kind == BodyKind::Predicted) {
      ++body.predicted;
      continue;
    }
    ++body.measured;
    body.gap = 0;
  }
  for (BodySteadiness& body : steadiness) body.longest_gap = std::max(body.longest_gap, body.gap);
}

std::vector<ReportRow> body_rows(const BodyRun& run, const BodyCounters& counters) {
  std::vector<ReportRow> rows;
  for (std::size_t b = 0; b < run.bodies.size(); ++b) {
    const BodySteadiness& body = run.steadiness[b];
    rows.push_back({"body " + run.bodies[b].name,
                    percent(share(body.measured, run.exposures)) + " of exposures measured",
                    body.measured == 0
                        ? "never found"
                        : "longest gap " + number_of(body.longest_gap) + ", predicted in " +
                              number_of(body.predicted) + ", ambiguous in " + number_of(body.ambiguous),
                    false});
  }
  if (run.bodies.empty()) return rows;
  rows.push_back({"bodies found and lost", number_of(counters.found) + " and " + number_of(counters.lost),
                  counters.ambiguous == 0
                      ? ""
                      : number_of(counters.ambiguous) + " times ambiguous: " + number_of(counters.kept) +
                            " had kept their names, " + number_of(counters.exchanged) + " were put right",
                  false});
  if (run.score) {
    const PoseResult& s = *run.score;
    char error[96];
    std::snprintf(error, sizeof error, "%.4f mm, %.4f degrees", 1e3 * s.rms_m, degrees(s.rms_rad));
    char worst[96];
    std::snprintf(worst, sizeof worst, "worst %.3f mm, %.3f degrees; of %llu poses", 1e3 * s.max_m,
                  degrees(s.max_rad), static_cast<unsigned long long>(s.poses));
    rows.push_back({"RMS error of poses", error, worst, true});
    rows.push_back({"recall of poses", percent(s.recall),
                    number_of(s.found) + " of " + number_of(s.expected) +
                        " bodies of which three markers were visible; " + number_of(s.astray) +
                        " poses at no body, " + number_of(s.silent_swaps) + " silent swaps of names",
                    false});
  }
  return rows;
}

nlohmann::ordered_json body_json(const BodyRun& run, const BodyCounters& counters) {
  nlohmann::ordered_json list = nlohmann::ordered_json::array();
  for (std::size_t b = 0; b < run.bodies.size(); ++b) {
    const BodySteadiness& body = run.steadiness[b];
    list.push_back({{"name", run.bodies[b].name},
                    {"measured", body.measured},
                    {"measured_share", share(body.measured, run.exposures)},
                    {"predicted", body.predicted},
                    {"ambiguous", body.ambiguous},
                    {"longest_gap", body.longest_gap}});
  }
  nlohmann::ordered_json json{{"exposures", run.exposures},      {"bodies", std::move(list)},
                              {"found", counters.found},         {"lost", counters.lost},
                              {"ambiguous", counters.ambiguous}, {"kept", counters.kept},
                              {"exchanged", counters.exchanged}};
  if (run.score) {
    const PoseResult& s = *run.score;
    json["score"] = {{"poses", s.poses},         {"expected", s.expected}, {"found", s.found},
                     {"recall", s.recall},       {"astray", s.astray},     {"silent_swaps", s.silent_swaps},
                     {"ambiguous", s.ambiguous}, {"rms_m", s.rms_m},       {"max_m", s.max_m},
                     {"rms_rad", s.rms_rad},     {"max_rad", s.max_rad}};
  }
  return json;
}

}  // namespace glint::apps
