// SPDX-License-Identifier: MIT
// One word for a calibration, by a rule that everybody can read.
#pragma once

#include <array>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "host/calibrate/coverage.hpp"
#include "host/calibrate/expected_error.hpp"
#include "host/calibrate/quality.hpp"
#include "host/target/target.hpp"

namespace glint {

/// "excellent", "good", "poor", "refuse".
const char* word_of(Verdict verdict);

/// One figure and what it is worth.
struct Criterion {
  std::string name;                   ///< "held-out error of the worst camera"
  std::string measured;               ///< "0.41 px rms (cam3)"
  std::array<std::string, 3> limits;  ///< for excellent, good and poor: "at most 0.5 px"; empty: no limit
  Verdict level = Verdict::Refuse;
  std::string remedy;  ///< what to do to improve it
};

struct Judgement {
  Verdict verdict = Verdict::Refuse;
  std::string rule;                 ///< one sentence: what this word means in figures
  std::vector<Criterion> criteria;  ///< worst first
  /// "held-out error of the worst camera: 0.41 px rms (cam3): ...do this"; of all that is not excellent.
  std::vector<std::string> reasons() const;
};

/// What a verdict is made from. Where something is not known, the verdict is at most as good as its proof.
struct VerdictInput {
  const CalibrationQuality* quality = nullptr;  ///< borrowed for the call, as all that follows
  std::span<const CoverageGrid> coverage;       ///< one per camera, of what was used
  const Overlap* overlap = nullptr;
  std::optional<ExpectedErrorSummary> expected;  ///< at the places of the samples; empty: not known
  TargetKind target = TargetKind::Wand;
  /// Judged are these cameras, which were placed anew among others that stayed; empty: all, and how they are
  /// joined.
  std::span<const std::uint32_t> only{};
};

Judgement judge(const VerdictInput& input);

}  // namespace glint
