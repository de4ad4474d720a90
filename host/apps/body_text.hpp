// SPDX-License-Identifier: MIT
// Rigid bodies of a run: which are looked for, what happened to them in words, and what it came to.
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include <nlohmann/json.hpp>

#include "host/base/ids.hpp"
#include "host/body/body_tracker.hpp"
#include "host/config/rig.hpp"
#include "host/output/report.hpp"
#include "host/sim/pose_score.hpp"
#include "host/sim/scene.hpp"

namespace glint::apps {

/// Those of the rig file, then those of the files; if there are none, and the scene has some, the scene's
/// own, named body1, body2, ... `scene` may be nullptr. Throws Error for what cannot be tracked together.
std::vector<BodyModel> chosen_bodies(const Rig& rig, std::span<const std::filesystem::path> files,
                                     const Scene* scene);

/// "tick 1234: body drone found"
std::string event_text(TriggerNo tick, const BodyEvent& event, std::span<const BodyModel> bodies);

/// The output's poses as the score takes them.
void to_scored(std::span<const TrackedBody> bodies, std::vector<ScoredPose>& poses);

/// How steadily one body was measured.
struct BodySteadiness {
  std::uint64_t measured = 0, predicted = 0, ambiguous = 0;  ///< exposures
  std::uint64_t longest_gap = 0;  ///< exposures on end without a measured pose, after the first one
  std::uint64_t gap = 0;          ///< the one that lasts
};

struct BodyRun {
  std::vector<BodyModel> bodies;
  std::vector<BodySteadiness> steadiness;  ///< by body
  std::uint64_t exposures = 0;             ///< in which the light was on
  std::optional<PoseResult> score;         ///< only against a simulator's truth

  /// Of every exposure in which the light was on.
  void add(std::span<const TrackedBody> rows) noexcept;
};

std::vector<ReportRow> body_rows(const BodyRun& run, const BodyCounters& counters);
nlohmann::ordered_json body_json(const BodyRun& run, const BodyCounters& counters);

}  // namespace glint::apps
