// SPDX-License-Identifier: MIT
// New results beside old ones: a ratio for each median, and a verdict only where noise does not explain it.
#pragma once

#include <optional>
#include <string>

#include "host/bench/results.hpp"

namespace glint::bench {

enum class Verdict : std::uint8_t { Faster, Slower, SameWithinNoise };

struct Change {
  double old_p50 = 0.0;
  double ratio = 0.0;  ///< new median / old median: under 1 is faster
  Verdict verdict = Verdict::SameWithinNoise;
};

/// Nothing where either has no samples or the old median is 0. Faster or slower only if the 95 % intervals of
/// the two medians do not overlap.
std::optional<Change> compare(const Summary& now, const Summary& before);

/// The row of `before` for that device and scene; nothing if there is none with figures.
const Row* matching_row(const Results& before, const std::string& device, const SceneKey& scene);

/// The series of that name (see for_each_series) in a row; nothing if it is not there.
const Series* series_named(const Row& row, const std::string& name);

/// Against a series of a row in older results. `before` may be null: nothing.
std::optional<Change> change_of(const std::string& series_name, const Series& now, const Row* before);

const char* text(Verdict verdict);

/// Older results and the name of the file that they came from.
struct Baseline {
  std::string path;
  Results results;
};

}  // namespace glint::bench
