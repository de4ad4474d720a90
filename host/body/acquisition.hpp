// SPDX-License-Identifier: MIT
// Samples for markers that have none, where their bodies expect them: all bodies jointly.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "host/body/body_state.hpp"
#include "host/track/assignment.hpp"

namespace glint {

/// Keeps its memory.
class Acquisition {
 public:
  /// Gives unused samples to markers that expect them, at most one to each. A sample that two markers expect
  /// nearly alike is left alone. A body without any sample takes two or none. Marks in `changed` which bodies
  /// have more samples than before.
  void run(std::span<const ShapedBody> shaped, std::span<BodyState> bodies, SampleIndex& index,
           std::vector<std::uint8_t>& changed, BodyCounters& counters);

 private:
  struct Row {
    std::uint32_t body, marker;
  };
  void drop_contested(BodyCounters& counters);

  std::vector<Row> rows_;
  std::vector<AssignmentEdge> edges_;
  std::vector<std::uint32_t> column_of_row_, order_;
  Assignment assignment_;
};

/// Whether the pose is known well enough to tell the body's markers apart by where they are expected.
bool sharp(const ShapedBody& shaped, const BodyState& body) noexcept;

}  // namespace glint
