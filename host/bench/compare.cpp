// SPDX-License-Identifier: MIT
// Matching and judging.
#include "host/bench/compare.hpp"

namespace glint::bench {

std::optional<Change> compare(const Summary& now, const Summary& before) {
  if (now.count == 0 || before.count == 0 || before.p50 <= 0.0) return std::nullopt;
  Change change;
  change.old_p50 = before.p50;
  change.ratio = now.p50 / before.p50;
  if (now.median_95.high < before.median_95.low) change.verdict = Verdict::Faster;
  if (now.median_95.low > before.median_95.high) change.verdict = Verdict::Slower;
  return change;
}

const Row* matching_row(const Results& before, const std::string& device, const SceneKey& scene) {
  for (const DeviceResult& d : before.devices) {
    if (d.name != device) continue;
    for (const Row& row : d.rows) {
      if (row.scene == scene && row.outcome == Outcome::Ok) return &row;
    }
  }
  return nullptr;
}

const Series* series_named(const Row& row, const std::string& name) {
  const Series* found = nullptr;
  for_each_series(row, [&](const std::string& n, const Series& series) {
    if (n == name) found = &series;
  });
  return found;
}

std::optional<Change> change_of(const std::string& series_name, const Series& now, const Row* before) {
  const Series* old = before == nullptr ? nullptr : series_named(*before, series_name);
  if (old == nullptr) return std::nullopt;
  return compare(now.summary, old->summary);
}

const char* text(Verdict verdict) {
  switch (verdict) {
    case Verdict::Faster:
      return "faster";
    case Verdict::Slower:
      return "slower";
    case Verdict::SameWithinNoise:
      break;
  }
  return "same within noise";
}

}  // namespace glint::bench
