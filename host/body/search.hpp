// SPDX-License-Identifier: MIT
// Lost bodies among the samples that nobody uses.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "host/body/body_finder.hpp"
#include "host/body/body_state.hpp"
#include "host/body/identity.hpp"
#include "host/track/assignment.hpp"

namespace glint {

/// Keeps its memory.
class BodySearch {
 public:
  BodySearch(const BodyShapes& shapes, const BodyTrackerOptions& options);

  /// Looks for the bodies marked in `seeking`, and hands what it finds out to them jointly, by where each was
  /// last. Those that got something are fitted, and count as seen in this exposure.
  void run(const BodyShapes& shapes, std::span<BodyState> bodies, std::span<const std::uint8_t> seeking,
           SampleIndex& index, BodyFitter& fitter, Identity& identity, std::vector<BodyEvent>& events,
           BodyCounters& counters);
  /// The next run() looks even at samples that it has looked at.
  void forget() noexcept { looked_at_ = 0; }

 private:
  bool worth_while(const BodyShapes& shapes, std::span<const std::uint8_t> seeking, const SampleIndex& index);
  void hand_out(const BodyShapes& shapes, std::span<BodyState> bodies, std::span<const std::uint8_t> seeking);
  double gain(const BodyState& body, const FoundBody& found) const noexcept;
  void doubt(const BodyShapes& shapes, std::span<const BodyState> bodies, Identity& identity,
             std::vector<BodyEvent>& events, BodyCounters& counters);

  BodyTrackerOptions options_;
  BodyFinder finder_;
  std::vector<std::uint32_t> wanted_, sample_of_point_, rows_, column_of_row_;
  std::vector<FinderPoint> points_;
  std::vector<FoundBody> found_;
  std::vector<AssignmentEdge> edges_;
  std::vector<BodyMotion> before_;  // of each row, as it was expected
  Assignment assignment_;
  std::uint64_t looked_at_ = 0;  // hash of the samples and bodies of the last search
  unsigned waited_ = 0;
};

}  // namespace glint
