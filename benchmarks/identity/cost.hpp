// SPDX-License-Identifier: MIT
// What tracking costs: processor time from blobs to tracks, by cameras and markers.
#pragma once

#include <cstdint>
#include <string>

namespace glint::identity {

struct Cost {
  std::uint32_t cameras = 0, markers = 0;
  std::uint64_t ticks = 0;
  double median_s = 0.0, p99_s = 0.0;  ///< of one thread, per exposure: matching, looks at pixels, tracking
  double looks = 0.0;                  ///< blobs looked at by their pixels, per exposure
};

/// Markers fly through the simulated rig; the first tenth of the exposures is not counted. `most_looks` as in
/// MatchOptions.
Cost cost_of(std::uint32_t cameras, std::uint32_t markers, std::uint64_t ticks, unsigned most_looks);

/// A line of a Markdown table; the head comes from cost_head().
std::string cost_row(const Cost& cost);
std::string cost_head();

}  // namespace glint::identity
